#!/usr/bin/env python3
"""Solves the problems of bench-planning with Tatu, with OMPL and with VAMP, in one run, and prints ratios.

    cargo build --release -p bench-planning
    python3 bench/planning/compare.py [path of bench-planning]

OMPL (PyPI `ompl`) gets a test of states in NumPy, with the same spheres as Tatu: its time is mostly that of the tests.
VAMP (PyPI `vamp-planner`) has its own spheres of a Panda, and its own compiled tests. Packages that are not installed
are reported and left out. Before, all of Tatu's paths are tested anew, in steps of 0.01 rad, by the test in NumPy, which
shares no code with Tatu.
"""

import json
import math
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
JOINTS = [
    ((0, 0, 0.333), 0), ((0, 0, 0), -90), ((0, -0.316, 0), 90), ((0.0825, 0, 0), 90),
    ((-0.0825, 0.384, 0), -90), ((0, 0, 0), 90), ((0.088, 0, 0), 90),
]
RANGE_OF_OMPL = 2.6


class Model:
    """The arm as spheres, and blocks."""

    def __init__(self, model, blocks, margin=0.0):
        self.margin = margin
        self.links = [(link["frame"], np.array(link["spheres"])) for link in model["links"]]
        self.pairs = model["pairs"]
        self.blocks = [
            (np.array(b["center"]), np.array(b["half"]), math.cos(b["yaw"]), math.sin(b["yaw"])) for b in blocks
        ]

    def places(self, state):
        """Returns the centres and radii of the spheres of each link."""
        frames, rotation, place = [], np.eye(3), np.zeros(3)
        for (position, degrees), angle in zip(JOINTS, state):
            c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            place = place + rotation @ np.array(position, dtype=float)
            rotation = rotation @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
            c, s = math.cos(angle), math.sin(angle)
            rotation = rotation @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            frames.append((rotation, place))
        found = []
        for frame, spheres in self.links:
            r, p = frames[frame] if frame is not None else (np.eye(3), np.zeros(3))
            found.append((spheres[:, :3] @ r.T + p, spheres[:, 3] - self.margin))
        return found

    def is_valid(self, state):
        links = self.places(state)
        centres = np.concatenate([c for c, _ in links[1:]])
        radii = np.concatenate([r for _, r in links[1:]])
        for middle, half, c, s in self.blocks:
            d = centres - middle
            local = np.stack([c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0], d[:, 2]], axis=1)
            beyond = np.maximum(np.abs(local) - half, 0.0)
            if np.any((beyond * beyond).sum(axis=1) <= radii * radii):
                return False
        for i, j in self.pairs:
            (a, ra), (b, rb) = links[i], links[j]
            if np.any(np.linalg.norm(a[:, None] - b[None], axis=2) <= ra[:, None] + rb[None]):
                return False
        return True


def tested(model, problems, rows):
    """Returns the number of states of Tatu's paths that the test in NumPy refuses by more than 1 mm, and of all."""
    bad = total = 0
    for problem, row in zip(problems, rows):
        arm = Model(model, problem["blocks"], margin=0.001)
        for a, b in zip(row["path"], row["path"][1:]):
            a, b = np.array(a), np.array(b)
            for share in np.linspace(0, 1, max(2, int(np.linalg.norm(b - a) / 0.01))):
                total += 1
                bad += not arm.is_valid(a + share * (b - a))
    return bad, total


def ompl_times(model, limits, problems):
    """Returns the times in ms, NaN where there is no solution, the time of the tests alone, and their number."""
    from ompl import base, geometric, util

    util.setLogLevel(util.LOG_ERROR)
    times, tests, counts = [], [], []
    for problem in problems:
        arm, spent = Model(model, problem["blocks"]), [0.0, 0]
        space = base.RealVectorStateSpace(7)
        bounds = base.RealVectorBounds(7)
        for i, (low, high) in enumerate(limits):
            bounds.setLow(i, low)
            bounds.setHigh(i, high)
        space.setBounds(bounds)
        setup = geometric.SimpleSetup(space)

        def is_valid(state, arm=arm, spent=spent):
            begun = time.perf_counter()
            valid = bool(arm.is_valid([state[i] for i in range(7)]))
            spent[0] += time.perf_counter() - begun
            spent[1] += 1
            return valid

        setup.setStateValidityChecker(is_valid)
        setup.getSpaceInformation().setStateValidityCheckingResolution(0.003)
        states = []
        for values in (problem["start"], problem["goal"]):
            state = space.allocState()
            for i, x in enumerate(values):
                state[i] = x
            states.append(state)
        setup.setStartAndGoalStates(*states)
        planner = geometric.RRTConnect(setup.getSpaceInformation())
        planner.setRange(RANGE_OF_OMPL)
        setup.setPlanner(planner)
        begun = time.perf_counter()
        solved = bool(setup.solve(20.0))
        times.append(1e3 * (time.perf_counter() - begun) if solved and setup.haveExactSolutionPath() else math.nan)
        tests.append(1e3 * spent[0])
        counts.append(spent[1])
    return times, tests, counts


def vamp_times(problems):
    """Returns the times in ms, NaN where an end is not valid for VAMP's spheres or there is no solution."""
    import vamp

    times = []
    panda, planner, settings, simplify = vamp.configure_robot_and_planner_with_kwargs("panda", "rrtc")
    sampler = panda.halton()
    for problem in problems:
        environment = vamp.Environment()
        for b in problem["blocks"]:
            environment.add_cuboid(vamp.Cuboid(b["center"], [0.0, 0.0, b["yaw"]], b["half"]))
        if not (panda.validate(problem["start"], environment) and panda.validate(problem["goal"], environment)):
            times.append(math.nan)
            continue
        result = planner(problem["start"], problem["goal"], environment, settings, sampler)
        times.append(result.nanoseconds / 1e6 if result.solved else math.nan)
    return times


def line(name, times, own):
    solved = [(a, b) for a, b in zip(times, own) if not math.isnan(a)]
    if not solved:
        return f"{name}: no problem solved"
    ratio = statistics.median(a / b for a, b in solved)
    middle = statistics.median(a for a, _ in solved)
    return f"{name}: {len(solved)} solved, median {middle:.3f} ms, {ratio:.2f} times Tatu's time (median of ratios)"


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/bench-planning"
    read = lambda *words: json.loads(subprocess.run([program, *words], capture_output=True, check=True).stdout)
    problems, model, rows = read("problems"), read("spheres"), read()
    tasks = problems["problems"]
    own = [row["plan_ms"] for row in rows]
    whole = [row["setup_ms"] + row["plan_ms"] + row["shorten_ms"] for row in rows]
    print(f"Tatu: {sum(r['solved'] for r in rows)} of {len(rows)} solved, median {statistics.median(own):.3f} ms to the"
          f" first path, {statistics.median(whole):.3f} ms with its shortening; longest {max(whole):.2f} ms;"
          f" same path with 1 and 2 threads: {sum(r['same'] for r in rows)}")
    bad, total = tested(model, tasks, rows)
    print(f"tested anew: {bad} of {total} states in collision by more than 1 mm")
    try:
        times, tests, counts = ompl_times(model, problems["limits"], tasks)
        share = sum(tests) / sum(t for t in times if not math.isnan(t))
        checks = [row["plan_checks"] for row in rows]
        more = statistics.median(a / b for a, b in zip(counts, checks))
        print(line("OMPL RRTConnect", times, own))
        print(f"  {share:.0%} of it in tests in Python; it makes {statistics.median(counts):.0f} tests, {more:.2f} times as"
              f" many as Tatu ({statistics.median(checks):.0f}), and without them takes"
              f" {statistics.median(t - x for t, x in zip(times, tests)):.2f} ms")
    except ImportError as error:
        print("OMPL is not installed:", error)
    try:
        print(line("VAMP rrtc", vamp_times(tasks), own))
    except ImportError as error:
        print("VAMP is not installed:", error)


if __name__ == "__main__":
    main()
