#!/usr/bin/env python3
"""Measures steps per second and memory with 100, 1,000 and 10,000 robots: swarm.py PROGRAM [THREADS]

The robots are the motes of scenes/showcase: two wheels, one range finder, a script that runs in parallel with the
others. The floor area per robot is constant. Prints a table in Markdown.
"""

import json
import math
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

SHOWCASE = Path(__file__).resolve().parent.parent / "scenes" / "showcase"
SPACING = 0.19  # m, between neighbours; a thousand robots need 36 m^2, as in swarm_1000.toml
WALLS = [(1, 0), (-1, 0), (0, 1), (0, -1)]


def scene(n):
    columns = math.isqrt(n) if math.isqrt(n) ** 2 == n else 40
    rows = n // columns
    half = [columns * SPACING / 2 + 0.1, rows * SPACING / 2 + 0.1]
    text = "format = 1\n[scene]\nphysics_dt_s = 0.05\nphysics_substeps = 4\n"
    text += '[[object]]\nkind = "shape"\nalias = "floor"\nprimitive = "plane"\nrespondable = true\n'
    for i, (x, y) in enumerate(WALLS):
        size = [0.1, 2 * half[1] + 0.2, 0.1] if x else [2 * half[0] + 0.2, 0.1, 0.1]
        text += f'[[object]]\nkind = "shape"\nalias = "wall_{i}"\nrespondable = true\nsize_m = {size}\n'
        text += f"position_m = [{x * (half[0] + 0.05)}, {y * (half[1] + 0.05)}, 0.05]\n"
    swarm = SHOWCASE / "models" / "mote" / "swarm.toml"
    return text + f'[[model]]\nfile = "{swarm}"\nrows = {rows}\ncolumns = {columns}\nspacing_m = {SPACING}\n'


def main():
    program = Path(sys.argv[1]).resolve()
    threads = sys.argv[2] if len(sys.argv) > 2 else "1"
    print("| robots | steps a second | times real time | memory |\n|---:|---:|---:|---:|")
    for n, steps in [(100, 200), (1000, 100), (10000, 40)]:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "scene.toml"
            file.write_text(scene(n))
            command = [program, "run", file, "--steps", str(steps), "--threads", threads, "--json"]
            models = dict(os.environ, TATU_MODEL_PATH=str(SHOWCASE / "models"))
            ran = subprocess.run(command, capture_output=True, check=True, env=models)
        told = json.loads(ran.stdout)
        rate = steps / told["wall_s"]
        memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        print(f"| {n:,} | {rate:.1f} | {rate * 0.05:.2f} | {memory:.0f} MB |", flush=True)


if __name__ == "__main__":
    main()
