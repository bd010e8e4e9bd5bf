"""Measures the rows about depth images: Tatu (`bench/beams`), Embree's packets, and MuJoCo on software OpenGL."""
import json
import statistics
import subprocess
import sys

from measure import PEERS, row
from sensors import agree, frames_on_two_threads, ours


def mujoco(mesh, seconds):
    """Returns the faster of EGL and OSMesa, both with Mesa's software renderer, or why none is available."""
    found, whys = [], []
    for method in ("egl", "osmesa"):
        command = [sys.executable, "mujoco_sensors.py", "--bench", "depth", "--method", method, "--seconds", str(seconds)]
        done = subprocess.run(command + (["--mesh"] if mesh else []), cwd=PEERS, capture_output=True, text=True)
        lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
        if done.returncode == 0 and lines:
            found.append(json.loads(lines[-1]))
        else:
            whys.append("%s: %s" % (method, (done.stderr.strip() or "it printed nothing").splitlines()[-1]))
    if found:
        return max(found, key=lambda line: line["frames_per_cpu_s"]), None
    return None, "; ".join(whys) + " (Debian: libegl1 libgl1-mesa-dri libosmesa6)"


def depth(embree, passes, with_mujoco, seconds, mesh):
    """Times complete depth images of 640 x 480 pixels on one core; the processes run alternately."""
    more = ["--mesh"] if mesh else []
    mine, packets, theirs, why = [], [], [], "MuJoCo is not installed"
    for _ in range(passes):
        mine.append(ours("depth", "--seconds", str(seconds), *more))
        best = embree.run("depth", seconds, mesh)
        if best:
            packets.append(best)
        if with_mujoco and (theirs or len(mine) == 1):
            line, why = mujoco(mesh, seconds)
            if line:
                theirs.append(line)

    def rate(results):
        return statistics.median(one["frames_per_cpu_s"] for one in results) if results else None

    what = "depth image with a mesh" if mesh else "depth image"
    if packets:
        row(what + ", Embree's packets", rate(mine), rate(packets), "1.2, then 2" if mesh else "3", "frames/s")
    row(what + ", MuJoCo's OpenGL", rate(mine), rate(theirs), "2.5" if mesh else "more than 1", "frames/s")
    if not theirs:
        print("    MuJoCo's images are not measured: %s" % why)
    agree("mean depth, m", "mean_depth_frame0", [mine[0]] + packets[:1] + theirs[:1])


def threads(passes, seconds):
    """Compares two threads with one, for the depth image with the mesh."""
    gain = statistics.median(frames_on_two_threads("depth", seconds, "--mesh") for _ in range(passes))
    row("depth image with a mesh, two threads", gain, None, "1.8", "x")
