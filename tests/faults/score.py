#!/usr/bin/env python3
"""Counts how many of the faulty plugins `tatu plugin check` finds, and whether it passes them without their faults.

score.py PROGRAM [--every N] [--out OUT]    builds all plugins below OUT, a temporary folder unless given, and checks
                                            each; of the faulty ones, each Nth

Prints a table, and exits with 1 if fewer than 90 % of the faults are found or a plugin without a fault fails. README.md defines
what counts as a finding.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
GOAL_PERCENT = 90
AT_ONCE = 2


def build(which, out):
    """Builds faulty plugins (`all`) or those without faults (`none`); returns their libraries by name."""
    subprocess.run([sys.executable, HERE / "faults.py", "make", which, out, "--rust"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    libraries = {}
    for folder in sorted(out.iterdir()):
        if folder.is_dir() and folder.name != "target":
            built = [*folder.glob("*.so"), *(out / "target/debug").glob(f"libtatu_{folder.name}.so")]
            libraries[folder.name] = built[0]
    return libraries


def findings(program, library):
    """Returns the errors that a check finds, or the message of the program if the plugin is not loaded."""
    ran = subprocess.run([program, "plugin", "check", library, "--json"], capture_output=True, text=True)
    if ran.returncode not in (0, 1):
        return [ran.stderr.strip() or f"exit code {ran.returncode}"]
    tests = json.loads(ran.stdout)["tests"]
    return [f"{f['place']}: {f['text']}" for t in tests for f in t["findings"] if f["level"] == "error"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    program = args.program.resolve()
    expected = json.loads((HERE / "expected.json").read_text())[::args.every]
    chosen = {fault["name"] for fault in expected}
    with tempfile.TemporaryDirectory() as temporary:
        out = args.out or Path(temporary)
        with ThreadPoolExecutor(AT_ONCE) as pool:
            good, faulty = build("none", out / "none"), build("all", out / "all")
            faulty = {name: library for name, library in faulty.items() if name in chosen}
            of_good = dict(zip(good, pool.map(lambda library: findings(program, library), good.values())))
            of_faulty = dict(zip(faulty, pool.map(lambda library: findings(program, library), faulty.values())))
    wrong = {name: found for name, found in of_good.items() if found}
    score = 0
    for fault in expected:
        found = of_faulty.get(fault["name"], [])
        hits = [f for f in found if any(word.lower() in f.lower() for word in fault["words"])]
        score += bool(hits)
        print(f"{'found ' if hits else 'MISSED'}  {fault['name']:<26}{(hits or found or ['nothing'])[0][:140]}")
    print(f"{score} of {len(expected)} faults are found; {len(wrong)} of {len(good)} plugins without a fault fail")
    for name, found in wrong.items():
        print(f"{name} has no fault, but: {found[0]}")
    sys.exit(0 if 100 * score >= GOAL_PERCENT * len(expected) and not wrong else 1)


main()
