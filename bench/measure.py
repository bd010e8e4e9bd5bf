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


def cores():
    """The two processors for what is run in turns; one twice where there is but one."""
    mine = sorted(os.sched_getaffinity(0))
    return mine[0], mine[min(1, len(mine) - 1)]


def in_turns(commands, turn=0.5):
    """What runs print that are all under way, one at a time for `turn` seconds while the others are stopped.

    Each is a command and the processors that it may use. What else the machine does meets all of them alike, and a median
    step or frame knows nothing of the stops.
    """
    runs = []
    with tempfile.TemporaryDirectory() as folder:
        try:
            for i, (command, on) in enumerate(commands):
                with open(os.path.join(folder, str(i)), "w") as out:
                    runs.append(subprocess.Popen(command, stdout=out, stderr=subprocess.DEVNULL,
                                                 preexec_fn=lambda on=on: os.sched_setaffinity(0, on)))
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
        for i, (run, (command, _)) in enumerate(zip(runs, commands)):
            if run.returncode != 0:
                sys.exit("failed: %s" % " ".join(command))
            with open(os.path.join(folder, str(i))) as out:
                found.append(json.load(out))
            if found[-1].get("errors"):
                sys.exit("the run has errors: %s" % found[-1]["errors"][:1])
        return found


def two_threads(command, median, turn=0.5):
    """How many times as fast two threads are as one, and what the runs have printed.

    `command` makes a command for a number of threads, `median` finds the median step in what it prints. One thread is timed
    on each of the two processors, since on a shared machine one may be a fifth slower than the other; their mean speed counts.
    """
    a, b = cores()
    runs = in_turns([(command(1), {a}), (command(1), {b}), (command(2), {a, b})], turn)
    on_a, on_b, both = (1 / median(run) for run in runs)
    return 2 * both / (on_a + on_b), runs


def has_mujoco():
    return all(importlib.util.find_spec(name) for name in ("mujoco", "numpy"))


def row(name, ours, peer, wanted, unit):
    line = "%-34s ours %10.4g %s" % (name, ours, unit)
    if peer:
        line += "   peer %10.4g   ratio %5.2f" % (peer, ours / peer)
    print("%s   (to reach: %s)" % (line, wanted), flush=True)
