#!/usr/bin/env python3
"""Measures the page in Chromium with software rendering: loading time, frame rate in large scenes, size of a film.

    python bench/page.py target/release/tatu

*loads*: time from the request of the page to its first frame of the scene, the median of five, in a running browser
with an empty cache. *pictures*: frame rate of the page while the simulation runs in real time, at 1366 x 768 pixels,
with the whole scene in view; the camera turns, so that every frame differs. The scene of 200 robots has twenty rows of
ten Pioneers; the mesh has 100,000 triangles and turns. Requires Chromium, and the packages websocket-client, pillow and
numpy."""

import math
import os
import statistics
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "vrep"))

from silhouettes import Page  # noqa: E402

FIRST = os.path.join(HERE, "../scenes/first/pioneer_avoids_walls.toml")
LUA = os.path.join(HERE, "../scenes/first/avoid_walls.lua")
FLOOR = 'format = 1\n[[object]]\nkind = "shape"\nalias = "floor"\nprimitive = "plane"\nrespondable = true\n'
SECONDS = 10
# Resolves at the first frame of the scene, that is, after the camera was moved to it.
LOADED = """(async () => { for (;;) { try { const [v, s] = await Promise.all([import('tatu/view/renderer'), import('tatu/scene/store')]);
  if (s.scene.objects.size && v.camera.position.x !== 3 && v.drawn > 1) return performance.now(); } catch {}
  await new Promise((f) => setTimeout(f, 5)); } })()"""
TURNS = """(async () => { const v = await import('tatu/view/renderer'); const THREE = await import('three');
  const up = new THREE.Vector3(0, 0, 1); const turn = () => { v.camera.position.sub(v.controls.target).applyAxisAngle(up, 0.01)
  .add(v.controls.target); v.controls.update(); v.redraw(); requestAnimationFrame(turn); }; turn();
  await new Promise((f) => setTimeout(f, 3000)); const [n, t] = [v.drawn, performance.now()];
  await new Promise((f) => setTimeout(f, SECONDS * 1000)); const seconds = (performance.now() - t) / 1000;
  return (v.drawn - n) / seconds; })()""".replace("SECONDS", str(SECONDS))


def robots(folder):
    with open(os.path.join(folder, "robots.toml"), "w") as f:
        f.write(FLOOR)
        for i in range(200):
            f.write('[[model]]\nmodel = "pioneer_p3dx"\nscript = "%s"\n' % LUA)
            f.write("position_m = [%g, %g, 0]\norientation_deg = [0, 0, %d]\n" % (1.5 * (i % 10), 1.5 * (i // 10), i * 137 % 360))
    return f.name


def mesh(folder):
    """Returns the mesh of a wavy sheet with 224 x 224 squares."""
    n = 224
    with open(os.path.join(folder, "sheet.obj"), "w") as f:
        for i in range(n + 1):
            for j in range(n + 1):
                f.write("v %g %g %g\n" % (i / n, j / n, 0.05 * math.sin(9 * i / n) * math.cos(7 * j / n)))
        for i in range(n):
            for j in range(n):
                a = i * (n + 1) + j + 1
                f.write("f %d %d %d\nf %d %d %d\n" % (a, a + 1, a + n + 2, a, a + n + 2, a + n + 1))
    with open(os.path.join(folder, "mesh.toml"), "w") as f:
        f.write(FLOOR + '[[object]]\nkind = "shape"\nalias = "sheet"\nprimitive = "mesh"\nmesh = "sheet.obj"\nposition_m = [0, 0, 0.5]\n')
        f.write("script = { text = '''function sysCall_actuation()\n sim.setObjectOrientation(sim.getObject('..'), -1, ")
        f.write("{0, 0, sim.getSimulationTime()})\nend''' }\n")
    return f.name


class Served:
    def __init__(self, program, scene):
        args = [program, "open", scene, "--no-browser"]
        self.process = subprocess.Popen(args, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.url = self.process.stdout.readline().strip()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()


def loads(program):
    with Served(program, FIRST) as served:
        times = []
        for _ in range(5):
            page = Page("about:blank")
            # Waits for the browser, which is still busy with its own initialisation.
            time.sleep(3)
            page.send("Page.navigate", url=served.url)
            times.append(page.value(LOADED) / 1000)
            page.close()
    print("loads          %.2f s (%s)" % (statistics.median(times), ", ".join("%.2f" % t for t in times)))


def pictures(program, name, scene):
    with Served(program, scene) as served:
        page = Page(served.url)
        page.send("Emulation.setDeviceMetricsOverride", width=1366, height=768, deviceScaleFactor=1, mobile=False)
        page.value(LOADED)
        page.value("document.getElementById('play').click()")
        time.sleep(2)
        rate = page.value(TURNS)
        factor = page.value("document.getElementById('factor').textContent")
        page.close()
    print("%-14s %.1f pictures a second, %s" % (name, rate, factor))


def film(program, folder):
    file = os.path.join(folder, "film.html")
    subprocess.run([program, "run", FIRST, "--seconds", "60", "--html", file], check=True, capture_output=True)
    print("film           %.2f MB for a minute of a Pioneer" % (os.path.getsize(file) / 1e6))


def main():
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        loads(program)
        pictures(program, "200 robots", robots(folder))
        pictures(program, "100,000", mesh(folder))
        film(program, folder)


if __name__ == "__main__":
    main()
