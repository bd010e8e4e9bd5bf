"""Functions shared by all rows, which measure the processor time of commands and print results."""
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
    """Runs a command. Returns its processor time (s), its output, its peak memory (MB) and its wall time (s)."""
    before = time.perf_counter()
    p = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, **more)
    out = p.stdout.read()
    _, status, used = os.wait4(p.pid, 0)
    if status != 0:
        sys.exit("failed: %s" % " ".join(command))
    return used.ru_utime + used.ru_stime, out, used.ru_maxrss / 1024, time.perf_counter() - before


def cores():
    """Returns two processors for alternating runs, or the same one twice if there is only one."""
    mine = sorted(os.sched_getaffinity(0))
    return mine[0], mine[min(1, len(mine) - 1)]


def in_turns(commands, turn=0.5):
    """Runs commands alternately for `turn` seconds each, while all others are stopped. Returns their outputs.

    Each item is a command and the processors that it can use. Other load on the machine affects all commands equally,
    and the stops do not affect the median of steps or frames.
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
    """Returns the speedup of two threads over one, and the output of the runs.

    `command` returns the command for a number of threads, and `median` extracts the median step from its output. One
    thread is timed on each of the two processors, because on a shared machine one can be 20 % slower than the other.
    The reference is their mean speed.
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
