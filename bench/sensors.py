"""Measures the rows about beams alone: a laser scanner and sonars, MuJoCo's rays, and Embree's packets."""
import json
import os
import shutil
import statistics
import subprocess
import sys

from measure import PEERS, RELEASE, cpu_of, row, two_threads

PROGRAM = os.path.join(RELEASE, "bench-beams")


def program():
    if not os.path.exists(PROGRAM):
        sys.exit("there is no %s: run `cargo build --release -p bench-beams`" % PROGRAM)
    return PROGRAM


def ours(*words):
    return json.loads(cpu_of([program(), *words])[1])


def frames_on_two_threads(bench, seconds, *more):
    """Returns the speedup of two threads over one."""
    words = [program(), bench, "--seconds", str(3 * seconds), *more, "--threads"]
    return two_threads(lambda n: [*words, str(n)], lambda run: run["median_s"], 0.1)[0]


def peer(*words):
    """Runs a peer's script, and returns the JSON object in its last line."""
    return json.loads(cpu_of([sys.executable, *words], cwd=PEERS)[1].splitlines()[-1])


class Embree:
    """The program with Embree's packets, built on first use. If the build fails, the reason is printed."""

    def __init__(self, folder):
        self.folder, self.built = folder, None

    def run(self, bench, seconds, mesh=False):
        """Returns the result with the best packet width, or `None` if the program cannot be built."""
        if self.built is None:
            self.built = self.build()
        if not self.built:
            return None
        triangles = os.path.join(self.folder, "mesh.bin" if mesh else "room.bin")
        if not os.path.exists(triangles):
            more = ["--mesh"] if mesh else []
            cpu_of([sys.executable, "triangles.py", *more, triangles], cwd=PEERS)
        found = [json.loads(cpu_of([self.built, triangles, bench, width, str(seconds)])[1]) for width in ("8", "16")]
        return max(found, key=lambda one: one["rays_per_cpu_s"])

    def build(self):
        program = os.path.join(self.folder, "embree_limit")
        if not shutil.which("g++"):
            print("    Embree's packets are not measured: g++ is not installed")
            return ""
        command = ["g++", "-O3", "-march=native", "embree_limit.cpp", "-lembree3", "-o", program]
        done = subprocess.run(command, cwd=PEERS, capture_output=True, text=True)
        if done.returncode != 0:
            print("    Embree's packets are not measured: embree_limit.cpp does not compile (apt-get install libembree-dev)")
            return ""
        return program


def agree(name, key, results):
    """Prints whether all results agree: the maximum deviation from the first, in percent."""
    first = results[0][key]
    worst = max(abs(one[key] - first) / first for one in results)
    print("    %s: %s, %.3f %% apart (at most 0.1 %%)" % (name, ", ".join("%.5g" % r[key] for r in results), 100 * worst))


def lidar(embree, passes, with_mujoco, seconds):
    """Measures 1080 beams over 270 degrees among 100 boxes; the processes run alternately."""
    mine, theirs, packets = [], [], []
    for _ in range(passes):
        mine.append(ours("lidar", "--seconds", str(seconds)))
        if with_mujoco:
            theirs.append(peer("mujoco_sensors.py", "--beams", "1080", "--seconds", str(seconds)))
        best = embree.run("lidar", seconds)
        if best:
            packets.append(best)

    def rate(results):
        return statistics.median(one["rays_per_cpu_s"] for one in results) if results else None

    row("laser, 1080 rays, MuJoCo", rate(mine), rate(theirs), "10", "rays/s")
    if packets:
        row("laser, 1080 rays, Embree's packets", rate(mine), rate(packets), "0.6, then 1", "rays/s")
    agree("mean range, m", "mean_range_frame0", [mine[0]] + theirs[:1] + packets[:1])


def sonars(passes, with_mujoco, seconds):
    """Measures 1000 robots with 16 cones each, and 16 rays each in MuJoCo. Targets move in each step."""
    mine, theirs = [], []
    for _ in range(passes):
        mine.append(ours("sonars", "--seconds", str(seconds))["robot_steps_per_cpu_s"])
        if with_mujoco:
            run = peer("mujoco_arena.py", "--robots", "1000", "--seconds", str(seconds), "--step", "0.01")
            theirs.append(run["robot_steps_per_cpu_s"] / run["cpu_parts"]["rays"])
    row("1000 x 16 cones, MuJoCo's rays", statistics.median(mine), theirs and statistics.median(theirs), "6",
        "robot-steps/s")
    gain = statistics.median(frames_on_two_threads("sonars", seconds) for _ in range(passes))
    row("1000 x 16 cones, two threads", gain, None, "1.8", "x")
