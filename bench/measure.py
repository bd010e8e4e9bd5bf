"""What all rows share: processor time of a command, and the line that is printed."""
import importlib.util
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
RELEASE = os.path.join(ROOT, "target", "release")
PEERS = os.path.join(HERE, "peers")


def cpu_of(command, **more):
    """Processor time of a command, s, its output, and its greatest memory, MB."""
    before = time.perf_counter()
    p = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, **more)
    out = p.stdout.read()
    _, status, used = os.wait4(p.pid, 0)
    if status != 0:
        sys.exit("failed: %s" % " ".join(command))
    return used.ru_utime + used.ru_stime, out, used.ru_maxrss / 1024, time.perf_counter() - before


def in_turns(commands, turn=0.5):
    """What runs print that are all under way, one at a time for `turn` seconds while the others are stopped.

    What else the machine does meets all of them alike, and a median step or frame knows nothing of the stops.
    """
    runs = []
    with tempfile.TemporaryDirectory() as folder:
        try:
            for i, command in enumerate(commands):
                with open(os.path.join(folder, str(i)), "w") as out:
                    runs.append(subprocess.Popen(command, stdout=out, stderr=subprocess.DEVNULL))
                runs[-1].send_signal(signal.SIGSTOP)
            left = list(runs)
            while left:
                for run in list(left):
                    run.send_signal(signal.SIGCONT)
                    try:
                        run.wait(turn)
                        left.remove(run)
                    except subprocess.TimeoutExpired:
                        run.send_signal(signal.SIGSTOP)
        finally:
            for run in runs:
                if run.poll() is None:
                    run.kill()
        found = []
        for i, (run, command) in enumerate(zip(runs, commands)):
            if run.returncode != 0:
                sys.exit("failed: %s" % " ".join(command))
            with open(os.path.join(folder, str(i))) as out:
                found.append(json.load(out))
            if found[-1].get("errors"):
                sys.exit("the run has errors: %s" % found[-1]["errors"][:1])
        return found


def has_mujoco():
    return all(importlib.util.find_spec(name) for name in ("mujoco", "numpy"))


def row(name, ours, peer, wanted, unit):
    line = "%-34s ours %10.4g %s" % (name, ours, unit)
    if peer:
        line += "   peer %10.4g   ratio %5.2f" % (peer, ours / peer)
    print("%s   (to reach: %s)" % (line, wanted), flush=True)
