#!/usr/bin/env python3
"""Compares accuracy and cost of Tatu's physics with MuJoCo's for three physics steps. The result is the table in
docs/physics.md.

    pip install mujoco numpy
    cargo build --release --workspace
    python3 bench/physics/table.py            prints the table
    python3 bench/physics/table.py --write    writes it into docs/physics.md
"""

import argparse
import math
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(Path(__file__).parent))

import cases
import engines

STEPS = (0.01, 0.005, 0.002)
ENGINES = {"tatu": "Tatu", "reduced": "reduced", "mujoco": "MuJoCo", "mujoco tuned": "tuned"}
BEGIN, END = "<!-- table begins: bench/physics/table.py --write -->", "<!-- table ends -->"


def shown(x):
    if math.isnan(x):
        return "–"
    if x < 0.0005:
        return "0"
    return f"{x:.3f}" if x < 10 else f"{x:.0f}"


def cost(x):
    return "–" if math.isnan(x) else f"{1e3 * x:.2f}"


def safely(run):
    try:
        return run()
    except Exception as e:  # A peer that diverges is also a result.
        print(f"  {e}", file=sys.stderr)
        return math.nan, math.nan


def measure(program, build):
    scene, seconds, names, error = build()
    rows = {}
    for dt in STEPS:
        for engine in ENGINES:
            def run():
                if engine == "reduced" and not any(b.parent for b in scene.bodies):
                    return math.nan, math.nan
                if engine in ("tatu", "reduced"):
                    solver = "reduced" if engine == "reduced" else "auto"
                    trace = engines.tatu(program, scene, seconds, dt, 4, names, solver)
                else:
                    trace = engines.of_mujoco(scene, seconds, dt, engine != "mujoco", names)
                return float(error(trace)), trace.cost
            rows[engine, dt] = safely(run)
    return rows


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=lambda p: str(Path(p).resolve()), default=str(ROOT / "target/release/tatu"))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    heads = [f"{e} {1e3 * dt:g} ms" for e in ENGINES.values() for dt in STEPS]
    lines = ["| case | | " + " | ".join(heads) + " |", "|---|---|" + "---:|" * len(heads)]
    for name, unit, build in cases.ALL:
        if options.only not in name:
            continue
        rows = measure(options.program, build)
        order = [(e, dt) for e in ENGINES for dt in STEPS]
        lines.append(f"| {name} | {unit} | " + " | ".join(shown(rows[k][0]) for k in order) + " |")
        lines.append("| | ms/s | " + " | ".join(cost(rows[k][1]) for k in order) + " |")
        print(*lines[-2:], sep="\n", file=sys.stderr)
    text = "\n".join(lines)
    if not options.write:
        print(text)
        return
    page = ROOT / "docs/physics.md"
    old = page.read_text()
    head, rest = old.split(BEGIN)
    page.write_text(f"{head}{BEGIN}\n\n{text}\n\n{END}{rest.split(END)[1]}")


main()
