"""Compares Tatu with its peers: the programs of each row run alternately, and the ratio of the medians is printed.

    python bench/run.py [--quick] [--rows arena100,arena1000,...]

Requires release builds (`cargo build --release`, and `-p bench-beams` for `lidar` and `sonars`); the peers require
Python packages: `pip install -r bench/peers/requirements.txt`. Without them, only Tatu's own figures are printed.
Compare ratios, not times on different machines, and run no other programs at the same time.
"""
import argparse
import json
import math
import os
import random
import re
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import arena  # noqa: E402
import images  # noqa: E402
import sensors  # noqa: E402
from measure import PEERS, RELEASE, ROOT, cores, cpu_of, has_mujoco, in_turns, row, two_threads  # noqa: E402

TATU = os.path.join(RELEASE, "tatu")

# Tatu's best step for the arena: one collision search per 50 ms, velocities solved in 5 substeps. Its paths agree with
# those of a 1 ms run within the 1 % that `motion` prints; with 4 substeps they do not.
PHYSICS = ["--set", "scene.physics_dt_s=0.05", "--set", "scene.physics_substeps=5"]

# The default of both programs: 5 ms, in Tatu with 4 substeps.
USUAL = ["--set", "scene.physics_dt_s=0.005", "--set", "scene.physics_substeps=4"]


def command(scene, steps, *more):
    return [TATU, "run", scene, "--steps", str(steps), "--json", *more]


def tatu(scene, steps, *more):
    cpu, out, rss, _ = cpu_of(command(scene, steps, *more))
    summary = json.loads(out)
    if summary["errors"]:
        sys.exit("the run has errors: %s" % summary["errors"][:1])
    return {"cpu": cpu, "wall": summary["wall_s"], "hash": summary["hash"], "objects": summary["objects"], "rss": rss}


class Scenes:
    """The scenes of the arena, which are written on first use."""

    def __init__(self, folder):
        self.folder = folder

    def __call__(self, robots):
        folder = os.path.join(self.folder, str(robots))
        path = os.path.join(folder, "arena.toml")
        return path if os.path.exists(path) else arena.write(folder, robots)


# Number of initial steps, in which scripts are created and started. They are excluded together with loading, because
# the peers also build their scenes before the clock starts.
BEGIN = 5


def rate(scene, robots, steps, physics):
    """Returns robot-steps per second of processor time, excluding loading and the start of scripts."""
    run, load = tatu(scene, BEGIN + steps, *physics), tatu(scene, BEGIN, *physics)
    return robots * steps / max(run["cpu"] - load["cpu"], 1e-9)


def mujoco(robots, seconds, step):
    out = cpu_of([sys.executable, "mujoco_arena.py", "--robots", str(robots), "--seconds", str(seconds),
                  "--step", str(step)], cwd=PEERS)[1]
    return json.loads(out)["robot_steps_per_cpu_s"]


def arena_row(scenes, robots, steps, passes, wanted, peer, physics=PHYSICS, step=0.01):
    ours, theirs = [], []
    for _ in range(passes):
        ours.append(rate(scenes(robots), robots, steps, physics))
        if peer:
            theirs.append(mujoco(robots, steps * 0.05, step))
    row("%d robots, %s" % (robots, "MuJoCo at 10 ms" if physics is PHYSICS else "both at 5 ms"), statistics.median(ours), theirs and statistics.median(theirs), wanted,
        "robot-steps/s")


def median_step(run):
    return run["step_wall_s"]["median"]


def growth(scenes, passes):
    """Compares the median step of 1000 robots with that of 10, alternately on one processor and then on another. Both
    runs have about the same duration."""
    pairs = []
    for core in cores() * passes:
        few, many = in_turns([(command(scenes(n), steps, *PHYSICS), {core}) for n, steps in ((10, 30000), (1000, 200))])
        pairs.append(median_step(many) / median_step(few) / 100)
    row("cost per robot, 1000 against 10", statistics.median(pairs), None, "at most 1.5", "x")


def threads(scenes, passes):
    """Compares the median step on one thread with that on two, alternately."""
    pairs, hashes = [], set()
    for _ in range(passes):
        gain, runs = two_threads(lambda n: command(scenes(1000), 200, *PHYSICS, "--threads", str(n)), median_step)
        hashes.update(run["hash"] for run in runs)
        pairs.append(gain)
    row("1000 robots, two threads", statistics.median(pairs), None, "1.6, same hashes", "x")
    print("    hashes: %s" % ("the same" if len(hashes) == 1 else "DIFFERENT"))


CALLS = 2_000_000
CALL_SCENE = """format = 1
[scene]
dt_s = 0.05
script_budget = 100000000000
[[object]]
kind = "joint"
alias = "joint"
[object.script]
text = '''
function sysCall_init() joint = sim.getObject('/joint') end
function sysCall_actuation()
    local read, s = sim.getJointPosition, 0
    for _ = 1, %d do %s end
end
'''
"""


def call(folder, passes, peer):
    """Measures a call that reads a joint minus the empty loop, with the instruction hook active."""
    costs, theirs = [], []
    for _ in range(passes):
        walls = []
        for body in ("s = s + read(joint)", "s = s + joint"):
            path = os.path.join(folder, "call.toml")
            with open(path, "w") as f:
                f.write(CALL_SCENE % (CALLS, body))
            walls.append(tatu(path, 1)["wall"])
        costs.append((walls[0] - walls[1]) / CALLS * 1e9)
        if peer:
            out = cpu_of([sys.executable, "calls.py", "--peer", "mujoco"], cwd=PEERS)[1]
            found = [json.loads(x) for x in out.splitlines() if x.startswith("{")]
            theirs.append(next(x["ns_per_call"] for x in found if x["call"].startswith("read joint position (")))
    row("a Lua call that reads a joint", statistics.median(costs), theirs and statistics.median(theirs), "100 ns", "ns")


SCANS = 1000
STEPS = 685
SCAN_SCENE = """
[[object]]
kind = "shape"
alias = "scanner"
position_m = [0.0, 0.0, 0.3]
detectable = false
[object.script]
text = '''
function sysCall_init() joint, ray = sim.getObject('/joint'), sim.getObject('/ray') end
function sysCall_sensing()
    local turn, look = sim.setJointPosition, sim.handleProximitySensor
    local first, step = -math.rad(120), math.rad(240) / %d
    for _ = 1, %d do
        for i = 0, %d do
            local r, d, p
            local a = first + i * step
            %s
        end
    end
end
'''
[[object]]
kind = "joint"
alias = "joint"
parent = "/scanner"
mode = "kinematic"
[[object]]
kind = "sensor"
sensor = "proximity"
alias = "ray"
parent = "/joint"
orientation_deg = [0.0, 90.0, 0.0]
volume = "ray"
range_m = 5.6
explicit = true
"""


def boxes(n, seed=5):
    """Returns a scene of boxes around the origin."""
    draw, text = random.Random(seed), ["format = 1\n[scene]\ndt_s = 0.05\nscript_budget = 100000000000\n"]
    for i in range(n):
        away, around = draw.uniform(1.5, 12.0), draw.uniform(-math.pi, math.pi)
        text.append('[[object]]\nkind = "shape"\nalias = "box%d"\nsize_m = [%.3f, %.3f, 1.0]\n'
                    'position_m = [%.4f, %.4f, 0.5]\norientation_deg = [0.0, 0.0, %.1f]\n'
                    % (i, draw.uniform(0.2, 0.8), draw.uniform(0.2, 0.8), away * math.cos(around),
                       away * math.sin(around), draw.uniform(0.0, 90.0)))
    return "".join(text)


def scan_call(folder, passes):
    """Measures 685 joint positions and rays in one script call among 100 boxes, with the hook, excluding loading."""
    path, found = os.path.join(folder, "scan_call.toml"), []
    for _ in range(passes):
        walls = []
        for body in ("turn(joint, a) r, d, p = look(ray)", ""):
            with open(path, "w") as f:
                f.write(boxes(100) + SCAN_SCENE % (STEPS - 1, SCANS, STEPS - 1, body))
            walls.append(tatu(path, 1)["wall"])
        # The empty loop is part of the scan; its duration is also printed separately.
        found.append((walls[0] / SCANS * 1e3, walls[1] / SCANS * 1e3))
    scan, empty = (statistics.median(x) for x in zip(*found))
    row("685 steps of joint and ray, a call", scan, None, "1 ms", "ms")
    print("    its empty loop takes %.3f ms; V-REP takes 94 ms for the whole call, %.0f times as long" % (empty, 94.0 / scan))


def startup(scenes, passes, peer):
    """Measures the time from process start to the end of a run of one step."""
    runs = [cpu_of([TATU, "run", scenes(1), "--steps", "1", "--json"]) for _ in range(3 * passes)]
    theirs = None
    if peer:
        out = cpu_of([sys.executable, "startup.py", "--peer", "mujoco", "--repeat", str(passes)], cwd=PEERS)[1]
        theirs = json.loads(out)["ready_ms"]
    row("start to first step", statistics.median(r[3] for r in runs) * 1e3, theirs, "50 ms", "ms")
    row("its peak memory", max(r[2] for r in runs), None, "50 MB", "MB")


def paths(trace, robots):
    """Returns the length of each robot's path in a trace."""
    length, last = [0.0] * robots, None
    for line in open(trace):
        objects = json.loads(line)["objects"]
        here = [objects["/r%d/robot" % i]["position"] for i in range(robots)]
        if last:
            for i, (a, b) in enumerate(zip(last, here)):
                length[i] += ((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5
        last = here
    return length


def motion(scenes, folder):
    """Measures how much paths of 2 s, before robots meet and differences grow, deviate from those of a 1 ms run."""
    robots, watch = 100, []
    for i in range(robots):
        watch += ["--watch", "/r%d/robot" % i]
    found = []
    for name, more in (("best", PHYSICS), ("exact", ["--set", "scene.physics_dt_s=0.001"])):
        trace = os.path.join(folder, name + ".jsonl")
        tatu(scenes(robots), 40, "--trace", trace, *watch, *more)
        found.append(paths(trace, robots))
    error = sum(abs(a - b) / b for a, b in zip(*found)) / robots
    row("motion error, mean of 100 paths", 100 * error, None, "1 %", "%")


def main():
    ap = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    ap.add_argument("--quick", action="store_true", help="one pass, shorter runs")
    ap.add_argument("--rows", default="motion,arena100,arena1000,usual1,usual100,growth,threads,call,scan_call,startup,lidar,sonars,"
                    "depth,depth_mesh,depth_threads")
    args = ap.parse_args()
    peer = has_mujoco()
    if not peer:
        print("MuJoCo is not installed (pip install -r bench/peers/requirements.txt): only Tatu's figures are printed\n")
    passes, rows = (1 if args.quick else 3), re.split("[, ]+", args.rows)
    alone = {"lidar", "sonars", "depth", "depth_mesh", "depth_threads"}
    if not os.path.exists(TATU) and not set(rows) <= alone:
        sys.exit("there is no %s: run `cargo build --release`" % os.path.relpath(TATU, ROOT))
    with tempfile.TemporaryDirectory() as folder:
        scenes, embree = Scenes(folder), sensors.Embree(folder)
        seconds = 1 if args.quick else 2
        table = {
            "motion": lambda: motion(scenes, folder),
            "arena100": lambda: arena_row(scenes, 100, 200 if args.quick else 400, passes, "1.7, then 3", peer),
            "arena1000": lambda: arena_row(scenes, 1000, 20 if args.quick else 60, passes, "6", peer),
            "usual1": lambda: arena_row(scenes, 1, 2000, passes, "3", peer, USUAL, 0.005),
            "usual100": lambda: arena_row(scenes, 100, 40 if args.quick else 100, passes, "3", peer, USUAL, 0.005),
            "growth": lambda: growth(scenes, passes),
            "threads": lambda: threads(scenes, passes),
            "call": lambda: call(folder, passes, peer),
            "scan_call": lambda: scan_call(folder, passes),
            "startup": lambda: startup(scenes, passes, peer),
            "lidar": lambda: sensors.lidar(embree, passes, peer, seconds),
            "sonars": lambda: sensors.sonars(passes, peer, seconds),
            "depth": lambda: images.depth(embree, passes, peer, seconds, False),
            "depth_mesh": lambda: images.depth(embree, passes, peer, seconds, True),
            "depth_threads": lambda: images.threads(passes, seconds),
        }
        for name in rows:
            if name not in table:
                sys.exit("there is no row `%s`; expected one of %s" % (name, ", ".join(table)))
            table[name]()


if __name__ == "__main__":
    main()
