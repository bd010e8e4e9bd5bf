#!/usr/bin/env python3
"""Measures every model with a card: models.py PROGRAM [--only CATEGORY | --without CATEGORY] [--hour]

With --hour, each demo scene runs for an hour of simulated time instead. Prints the errors; the exit code is 1 if there
are any.
"""

import argparse
import json
import math
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

AT_ONCE = 2
MODELS = Path(__file__).resolve().parent.parent / "models"


def measured(program, folder):
    if not (folder / "card.toml").exists():
        return []
    ran = subprocess.run([program, "measure", folder, "--json"], capture_output=True, text=True)
    if ran.returncode not in (0, 1) or ran.stderr.strip():
        return [ran.stderr.strip()]
    wrong = [row for row in json.loads(ran.stdout) if row["verdict"] != "ok"]
    told = "{measure}: {verdict}: {measured} {unit}, expected {expected} within {allowed}, on the card {recorded}"
    return [told.format(**row) for row in wrong]


def runs(program, folder):
    """Checks that the demo runs for an hour without an error, and that positions stay finite and near the origin."""
    demo = folder / "demo.toml"
    if not demo.exists():
        return []
    command = [program, "run", demo, "--seconds", "3600", "--json"]
    ran = subprocess.run(command, capture_output=True, text=True, cwd="/tmp")
    if ran.returncode != 0:
        return [ran.stderr.strip()[-2000:]]
    objects = json.loads(ran.stdout)["objects"].items()
    return [f"{path} is at {o['position']}" for path, o in objects if not all(abs(x) < 1e3 for x in o["position"])]


def category(folder):
    found = re.search(r'^category = "(.*)"', (folder / "model.toml").read_text(), re.MULTILINE)
    return found.group(1) if found else ""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=Path)
    parser.add_argument("--only")
    parser.add_argument("--without")
    parser.add_argument("--hour", action="store_true")
    args = parser.parse_args()
    program = args.program.resolve()
    folders = sorted(f.parent for f in MODELS.glob("*/model.toml"))
    if args.only or args.without:
        folders = [f for f in folders if (category(f) == args.only) == bool(args.only) and category(f) != args.without]

    def one(folder):
        begin = time.monotonic()
        return (runs if args.hour else measured)(program, folder), time.monotonic() - begin

    failed = 0
    with ThreadPoolExecutor(AT_ONCE) as pool:
        for folder, (wrong, seconds) in zip(folders, pool.map(one, folders)):
            print(f"{'FAIL' if wrong else 'pass'}  {folder.name}  {math.ceil(seconds)} s", flush=True)
            for text in wrong:
                print(f"      {text}")
            failed += bool(wrong)
    print(f"{len(folders) - failed} of {len(folders)} models pass")
    sys.exit(1 if failed or not folders else 0)


if __name__ == "__main__":
    main()
