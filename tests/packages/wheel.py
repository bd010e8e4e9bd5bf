#!/usr/bin/env python3
"""Tests a wheel as on a machine that has only Python: in new virtual environments, without a compiler in PATH.

    tests/packages/wheel.py WHEEL [--python PYTHON]... [--hash HASH]

Checks its size, that no file needs a newer glibc than 2.28 (`elf.py`), that `abi3audit` finds nothing, and, with each
Python, that `python -m tatu_sim doctor` succeeds, a program of five lines drives a robot, the command line runs, and
the page is served.
"""

import argparse
import re
import signal
import subprocess
import sys
import tempfile
import urllib.request
from pathlib import Path

HERE = Path(__file__).resolve().parent
LARGEST_MB = 60
FIVE_LINES = """
import tatu_sim
world = tatu_sim.World("first/pioneer_avoids_walls.toml")
start = world["/Pioneer_p3dx"].position
world.run(5.0)
print("moved", abs(world["/Pioneer_p3dx"].position - start).max() > 0.3, f"{world.hash:016x}")
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--python", action="append", default=[], help="an interpreter; by default this one")
    parser.add_argument("--hash", help="expected hash of the run of 5 s, as other packages compute it")
    parser.add_argument("--any-glibc", action="store_true", help="a wheel for this machine only")
    args = parser.parse_args()
    wheel = args.wheel.resolve()
    size = wheel.stat().st_size / 1e6
    check(size < LARGEST_MB, f"size {size:.1f} MB")
    if not args.any_glibc:
        run([sys.executable, str(HERE / "elf.py"), str(wheel), "--glibc", "2.28"])
    hashes = set()
    with tempfile.TemporaryDirectory(prefix="tatu-wheel-") as folder:
        audit(Path(folder), wheel)
        for number, python in enumerate(args.python or [sys.executable]):
            hashes.add(tried(Path(folder) / str(number), python, wheel))
    check(len(hashes) == 1, f"one hash with each Python: {', '.join(sorted(hashes))}")
    if args.hash:
        check(hashes == {args.hash}, f"the hash is that of other packages, {args.hash}")


def audit(folder, wheel):
    """Checks with abi3audit that the module uses only the stable ABI, as its file name declares."""
    run([sys.executable, "-m", "venv", str(folder / "audit")])
    bin = folder / "audit/bin"
    run([str(bin / "pip"), "install", "-q", "abi3audit"])
    out = run([str(bin / "abi3audit"), "--strict", "--summary", str(wheel)])
    print(out.strip().splitlines()[-1] if out.strip() else "abi3audit: no output")


def tried(folder, python, wheel):
    """Installs the wheel and uses it; returns the hash of the run."""
    run([python, "-m", "venv", str(folder)])
    bin = folder / "bin"
    run([str(bin / "pip"), "install", "-q", str(wheel)])
    # The PATH contains no compiler, no Cargo and no other Tatu.
    env = {"PATH": str(bin), "HOME": str(folder), "LANG": "C.UTF-8"}
    here = {"env": env, "cwd": folder}
    version = run([str(bin / "python"), "--version"], **here).strip()
    doctor = run([str(bin / "python"), "-m", "tatu_sim", "doctor"], **here)
    check("as expected" in doctor, f"{version}: doctor")
    begin = "import time, numpy; t = time.perf_counter(); import tatu_sim; print(time.perf_counter() - t)"
    seconds = min(float(run([str(bin / "python"), "-c", begin], **here)) for _ in range(3))
    check(seconds < 0.3, f"{version}: import in {1e3 * seconds:.0f} ms")
    moved, _, found = run([str(bin / "python"), "-c", FIVE_LINES], **here).rpartition(" ")
    check(moved == "moved True", f"{version}: five lines drive the robot, {found.strip()}")
    check("pioneer_p3dx" in run([str(bin / "tatu"), "list", "models"], **here), f"{version}: console script `tatu`")
    check(page(bin, here), f"{version}: `python -m tatu_sim open` serves the page")
    return found.strip()


def page(bin, here):
    """Opens a scene in the page, without a browser, and fetches it."""
    command = [str(bin / "python"), "-m", "tatu_sim", "open", "pioneer_avoids_walls", "--no-browser"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **here)
    try:
        for line in server.stdout:
            found = re.search(r"http://\S+", line)
            if found:
                text = urllib.request.urlopen(found.group(), timeout=20).read().decode()
                return "<script" in text
        return False
    finally:
        server.send_signal(signal.SIGINT)
        server.wait(20)


def run(command, **more):
    done = subprocess.run(command, capture_output=True, text=True, **more)
    if done.returncode != 0:
        sys.exit(f"FAIL  {' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def check(holds, what):
    print("pass " if holds else "FAIL ", what, flush=True)
    if not holds:
        sys.exit(1)


if __name__ == "__main__":
    main()
