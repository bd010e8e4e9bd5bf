"""What all rows share: processor time of a command, and the line that is printed."""
import importlib.util
import os
import subprocess
import sys
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


def has_mujoco():
    return all(importlib.util.find_spec(name) for name in ("mujoco", "numpy"))


def row(name, ours, peer, wanted, unit):
    line = "%-34s ours %10.4g %s" % (name, ours, unit)
    if peer:
        line += "   peer %10.4g   ratio %5.2f" % (peer, ours / peer)
    print("%s   (to reach: %s)" % (line, wanted), flush=True)
