#!/usr/bin/env python3
"""Runs the tests of the workspace, and names the slowest ones.

    tests/run.py                              all tests
    tests/run.py robots:: page::              tests whose names contain one of these
    tests/run.py --skip page:: --skip robots::
    tests/run.py --built FILE robots::        runs tests that were built before; FILE: the output of `BUILD`
    tests/run.py --slowest 50                 the slowest tests of earlier runs; runs nothing

Everything is built first, with one set of features, unless `--built` is given. A failed test stops nothing; failed tests
are named at the end, with their output, and so are ignored ones, with their reasons. Durations are stored in
`test-times.json` in the target folder.

The test harness reports only when a test ends. It starts tests in the order in which it lists them, the next one when a
running one ends, so the beginning of each test follows from the ends of others.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
TIMES = TARGET / "test-times.json"
BUILD = ["cargo", "build", "--workspace", "--lib", "--bins", "--tests", "--message-format=json-render-diagnostics"]
# What the harness prints at the end of a test; a program that a test has started may have printed in the same line.
ENDED = re.compile(r"test (\S+)(?: - should panic)? \.\.\. (ok|FAILED|ignored)(?:, (.*))?$")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("names", nargs="*", help="parts of names of tests to run")
    arguments.add_argument("--skip", action="append", default=[], help="part of names of tests to skip")
    arguments.add_argument("--binary", default="", help="part of the name of the test binaries to run: `engine/beams`")
    arguments.add_argument("--threads", type=int, default=os.cpu_count() or 1, help="tests that run at a time")
    arguments.add_argument("--slowest", type=int, metavar="N", help="print the N slowest tests of earlier runs")
    arguments.add_argument("--built", type=Path, metavar="FILE",
                           help=f"build nothing; FILE contains what `{' '.join(BUILD)}` has printed")
    options = arguments.parse_args()
    if options.slowest:
        return slowest(options.slowest)
    done = []
    for binary in binaries(options.built.read_text() if options.built else build()):
        if options.binary in binary[0]:
            of_binary = run(binary, options)
            remember(of_binary)
            done += of_binary
    return report(done)


def build():
    """Builds all tests, and returns what cargo prints about them."""
    process = subprocess.run(BUILD, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if process.returncode != 0:
        sys.exit("the tests cannot be built")
    return process.stdout


def binaries(messages):
    """Returns the name, the folder and name of the package, and the path of each test binary in messages of cargo."""
    names = subprocess.run(["cargo", "metadata", "--no-deps", "--offline", "--format-version", "1"], cwd=ROOT,
                           stdout=subprocess.PIPE, text=True, check=True).stdout
    names = {package["manifest_path"]: package["name"] for package in json.loads(names)["packages"]}
    found = []
    for line in messages.splitlines():
        message = json.loads(line)
        if message.get("reason") == "compiler-artifact" and message["profile"]["test"] and message["executable"]:
            folder, package = Path(message["manifest_path"]).parent, names[message["manifest_path"]]
            found.append((f"{folder.relative_to(ROOT)}:{message['target']['name']}", folder, package,
                          message["executable"]))
    return sorted(found)


def run(binary, options):
    """Runs the tests of one binary; returns a dictionary for each test."""
    name, folder, package, path = binary
    chosen = [*options.names, *(word for skipped in options.skip for word in ("--skip", skipped))]
    # An empty element would stand for the current folder.
    more = [os.environ["LD_LIBRARY_PATH"]] if os.environ.get("LD_LIBRARY_PATH") else []
    libraries = [TARGET / "debug" / "deps", TARGET / "debug", *more]
    environment = dict(os.environ, CARGO_MANIFEST_DIR=str(folder), CARGO_PKG_NAME=package, CARGO="cargo",
                       LD_LIBRARY_PATH=":".join(map(str, libraries)))
    listed = subprocess.run([path, "--list", *chosen], cwd=folder, env=environment, capture_output=True, text=True)
    waiting = [line.removesuffix(": test") for line in listed.stdout.splitlines() if line.endswith(": test")]
    if not waiting:
        return []
    print(f"\n== {name}: {len(waiting)} tests", flush=True)
    command = [path, "--test-threads", str(options.threads), *chosen]
    process = subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               text=True, errors="replace")
    waiting.reverse()
    begun, done, output, in_tests = {}, [], [], True

    def start():
        while waiting and len(begun) < options.threads:
            begun[waiting.pop()] = time.monotonic()

    start()
    for line in process.stdout:
        ended = ENDED.search(line.rstrip()) if in_tests else None
        if ended and ended[1] in begun:
            test, verdict, reason = ended.groups(default="")
            seconds = time.monotonic() - begun.pop(test)
            start()
            done.append({"binary": name, "test": test, "verdict": verdict, "reason": reason, "seconds": seconds})
            if verdict == "FAILED":
                print(line, end="", flush=True)
        else:
            in_tests = in_tests and line.strip() != "failures:"
            output.append(line)
    process.wait()
    failed = [test for test in done if test["verdict"] == "FAILED"]
    if process.returncode != 0:
        print("".join(output), flush=True)
        if not failed:
            # The process died, for example by a signal: which test was at fault is unknown.
            done += [{"binary": name, "test": test, "verdict": "FAILED", "reason": f"ended with {process.returncode}",
                      "seconds": 0.0} for test in begun or {"?": 0}]
    elif begun:
        # Their lines were not recognised, but all tests have passed.
        done += [{"binary": name, "test": test, "verdict": "ok", "reason": "", "seconds": 0.0}
                 for test in [*begun, *waiting]]
    return done


def remember(done):
    """Adds the durations of this run to those of earlier ones."""
    times = json.loads(TIMES.read_text()) if TIMES.exists() else {}
    for test in done:
        if test["verdict"] != "ignored":
            times[f"{test['binary']} {test['test']}"] = round(test["seconds"], 2)
    TIMES.parent.mkdir(parents=True, exist_ok=True)
    TIMES.write_text(json.dumps(times, indent=1, sort_keys=True) + "\n")


def slowest(count):
    if not TIMES.exists():
        sys.exit(f"there is no {TIMES}: run tests/run.py first")
    times = json.loads(TIMES.read_text())
    for name, seconds in sorted(times.items(), key=lambda item: -item[1])[:count]:
        print(f"{seconds:7.1f} s  {name}")
    print(f"{sum(times.values()):7.1f} s  all {len(times)} tests, one after the other")


def report(done):
    """Prints what was ignored, and why, and what failed; returns the exit status."""
    reasons = {}
    for test in done:
        if test["verdict"] == "ignored":
            reasons.setdefault(test["reason"] or "no reason given", []).append(test["test"])
    for reason, tests in sorted(reasons.items()):
        print(f"\nignored, because {reason}:\n  " + "\n  ".join(tests))
    failed = [test for test in done if test["verdict"] == "FAILED"]
    passed = sum(test["verdict"] == "ok" for test in done)
    print(f"\n{passed} tests passed, {len(failed)} failed, {sum(map(len, reasons.values()))} ignored")
    for test in failed:
        print(f"FAILED: {test['binary']} {test['test']} {test['reason']}".rstrip())
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
