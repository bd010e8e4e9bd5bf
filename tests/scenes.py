#!/usr/bin/env python3
"""Runs each scene of scenes/showcase for the time that its checks need: scenes.py PROGRAM

A line `# Test: runs N s` of a scene states the simulated time. Its scripts raise an error if the robots do not behave
as they should. Prints the errors; the exit code is 1 if there are any.
"""

import math
import re
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

AT_ONCE = 2
SCENES = Path(__file__).resolve().parent.parent / "scenes" / "showcase"


def run(program, scene):
    begin = time.monotonic()
    seconds = re.search(r"^# Test: runs (\d+) s", scene.read_text(), re.MULTILINE)
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "run", scene, "--seconds", seconds.group(1) if seconds else "10", "--strict", "--allow", "python"]
        # The scene's own ports may be in use by another program.
        for service in re.findall(r'^\[\[service\]\]\nid = "(\w+)"', scene.read_text(), re.MULTILINE):
            command += ["--service", f"{service}:port=0"]
        ran = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    return ran.returncode, ran.stderr.strip()[-2000:], math.ceil(time.monotonic() - begin)


def main():
    program = Path(sys.argv[1]).resolve()
    scenes = sorted(SCENES.glob("*.toml"))
    failed = 0
    with ThreadPoolExecutor(AT_ONCE) as pool:
        for scene, (code, said, seconds) in zip(scenes, pool.map(lambda s: run(program, s), scenes)):
            print(f"{'FAIL' if code else 'pass'}  {scene.stem}  {seconds} s", flush=True)
            if code:
                print(said)
            failed += bool(code)
    print(f"{len(scenes) - failed} of {len(scenes)} scenes pass")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
