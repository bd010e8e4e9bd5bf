"""Rows of beams and images: our own (`bench/beams`) beside Embree's packets and MuJoCo's.

All figures are of processor time, so that other work on the machine counts little; what has no processor time to go by
says so.
"""
import json
import os
import shutil
import statistics
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
PEERS = os.path.join(HERE, "peers")
OURS = os.path.join(os.path.dirname(HERE), "target", "release", "bench-beams")


def last_json(command, cwd=None):
    """The last JSON line that a command prints, or why there is none."""
    try:
        p = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=600)
    except (OSError, subprocess.TimeoutExpired) as e:
        return None, str(e)
    lines = [x for x in p.stdout.splitlines() if x.startswith("{")]
    if p.returncode != 0 or not lines:
        said = (p.stderr.strip() or p.stdout.strip() or "it printed nothing").splitlines()
        return None, said[-1]
    return json.loads(lines[-1]), None


class Embree:
    """The peer's limit in native code, built here; triangles are written when first asked for."""

    def __init__(self, folder):
        self.folder, self.program, self.missing = folder, os.path.join(folder, "embree_limit"), None
        if not shutil.which("g++"):
            self.missing = "there is no g++"
            return
        source = os.path.join(PEERS, "embree_limit.cpp")
        build = ["g++", "-O3", "-march=native", source, "-lembree3", "-o", self.program]
        if subprocess.run(build, capture_output=True).returncode != 0:
            self.missing = "embree_limit.cpp does not build (Debian: libembree-dev)"

    def triangles(self, mesh):
        path = os.path.join(self.folder, "mesh.bin" if mesh else "boxes.bin")
        if not os.path.exists(path):
            more = ["--mesh"] if mesh else []
            subprocess.run([sys.executable, "triangles.py", *more, path], cwd=PEERS, check=True)
        return path

    def best(self, bench, mesh, seconds):
        """The better of its two widths of packets."""
        if self.missing:
            return None, self.missing
        found = []
        for width in ("8", "16"):
            line, why = last_json([self.program, self.triangles(mesh), bench, width, str(seconds)])
            if line is None:
                return None, why
            found.append(line)
        return max(found, key=lambda line: line["frames_per_cpu_s"]), None


def mujoco(mesh, seconds):
    """MuJoCo's renderer on Mesa's software OpenGL; the better of EGL and OSMesa."""
    found, whys = [], []
    for method in ("egl", "osmesa"):
        command = [sys.executable, "mujoco_sensors.py", "--bench", "depth", "--method", method]
        line, why = last_json(command + ["--seconds", str(seconds)] + (["--mesh"] if mesh else []), PEERS)
        if line:
            found.append(line)
        else:
            whys.append("%s: %s" % (method, why))
    if not found:
        return None, "; ".join(whys) + " (Debian: libegl1 libgl1-mesa-dri libosmesa6)"
    return max(found, key=lambda line: line["frames_per_cpu_s"]), None


def ours(bench, seconds, *more):
    line, why = last_json([OURS, bench, "--seconds", str(seconds), *more])
    if line is None:
        sys.exit("bench-beams: %s (cargo build --release -p bench-beams)" % why)
    return line


def depth(row, folder, passes, seconds, mesh):
    """A depth image of 640 x 480 pixels, one core, whole frames."""
    more = ["--mesh"] if mesh else []
    embree = Embree(folder)
    peers = {
        "Embree": (lambda: embree.best("depth", mesh, seconds), "1.2, then 2" if mesh else "3"),
        "MuJoCo, software OpenGL": (lambda: mujoco(mesh, seconds), "2.5" if mesh else "more"),
    }
    rates, theirs, missing = [], {name: [] for name in peers}, {}
    for _ in range(passes):
        rates.append(ours("depth", seconds, *more))
        for name, (measure, _) in peers.items():
            line, why = measure() if name not in missing else (None, missing[name])
            if line:
                theirs[name].append(line)
            else:
                missing[name] = why
    own = statistics.median(line["frames_per_cpu_s"] for line in rates)
    what = "depth, boxes and mesh" if mesh else "depth, boxes"
    for name, (_, wanted) in peers.items():
        if not theirs[name]:
            print("%s, %s: skipped: %s" % (what, name, missing[name]))
            row(what, own, None, wanted, "frames a CPU second")
            continue
        peer = statistics.median(line["frames_per_cpu_s"] for line in theirs[name])
        row("%s, %s" % (what, name), own, peer, wanted, "frames a CPU second")
        off = rates[0]["mean_depth_frame0"] / theirs[name][0]["mean_depth_frame0"] - 1
        print("    mean depth: ours is %+.4f %% off (to reach: 0.1 %%)" % (100 * off))


def depth_threads(row, passes, seconds):
    """The same with the mesh, one thread against two: wall time, so let nothing else run."""
    found = []
    for _ in range(passes):
        one, two = (ours("depth", seconds, "--mesh", "--threads", n) for n in ("1", "2"))
        found.append(two["frames_per_s"] / one["frames_per_s"])
    row("depth with mesh, two threads", statistics.median(found), None, "1.8", "x")
