#!/usr/bin/env python3
"""Checks every plugin that comes with a program: check_plugins.py PROGRAM

Prints the findings; the exit code is 1 if there are any. own_plugins_check.toml lists allowed findings, with reasons.
"""

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

CONFIG = Path(__file__).resolve().parent / "own_plugins_check.toml"
AT_ONCE = 2
# Commands of LuaSocket may block indefinitely, depending on their arguments: only tests that do not call them are run.
# Repeating batches of images with hundreds of thousands of pixels takes minutes in a build without optimisation.
SKIP = {"tatu.commands.luasocket": "arguments,repeat,worlds,snapshots,reload,load,leaks,cost",
        "tatu.sensor.depth_camera": "batches,extremes"}
# A test that takes longer fails, s. Other stages of the checks slow it down.
TIMEOUT_S = "300"


def check(program, plugin):
    command = [program, "plugin", "check", plugin["path"], "--config", CONFIG, "--timeout", TIMEOUT_S, "--json"]
    if plugin["id"] in SKIP:
        command += ["--skip", SKIP[plugin["id"]]]
    ran = subprocess.run(command, capture_output=True, text=True)
    if ran.returncode not in (0, 1):
        return [ran.stderr.strip()]
    tests = json.loads(ran.stdout)["tests"]
    return [f"{t['test']}: {f['place']}: {f['text']}" for t in tests for f in t["findings"] if f["level"] == "error"]


def main():
    program = Path(sys.argv[1]).resolve()
    plugins = json.loads(subprocess.run([program, "list", "plugins", "--json"], capture_output=True, check=True).stdout)
    with ThreadPoolExecutor(AT_ONCE) as pool:
        results = list(pool.map(lambda plugin: check(program, plugin), plugins))
    for plugin, wrong in zip(plugins, results):
        print(f"{'FAIL' if wrong else 'pass'}  {plugin['id']}")
        for text in wrong:
            print(f"      {text}")
    passed = sum(not wrong for wrong in results)
    print(f"{passed} of {len(plugins)} plugins pass")
    sys.exit(0 if passed == len(plugins) and plugins else 1)


main()
