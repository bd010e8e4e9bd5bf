"""Compares the page's image of a scene with that of `tatu look` by the overlap of silhouettes.

    python bench/vrep/silhouettes.py SCENE... [--program target/release/tatu]

Both render the shapes of a scene, except floors, with the same camera. The page renders them white on black.
`tatu look` renders the scene twice, with and without the shapes, 300 m above its floor so that the image contains no
shadow; the pixels that differ belong to shapes. The printed value is the intersection of both silhouettes divided by
their union. Only `tatu look` smooths edges, which adds a border of half a pixel, so thin and small shapes overlap less.
Requires Chromium, and the packages websocket-client, pillow and numpy.
"""
import argparse
import base64
import io
import json
import os
import subprocess
import tempfile
import time
import urllib.request

import numpy
import websocket
from PIL import Image

HERE = os.path.dirname(os.path.abspath(__file__))
WIDTH, HEIGHT = 800, 500
UP = 300.0
BROWSER = ["chromium", "--headless=new", "--no-sandbox", "--enable-unsafe-swiftshader", "--use-angle=swiftshader"]

DRAW = """(async () => {
  const [view, objects, { scene }, net, THREE] = await Promise.all(
    ["tatu/view/renderer", "tatu/view/objects", "tatu/scene/store", "tatu/net/connection", "three"].map((m) => import(m)));
  objects.root.updateMatrixWorld(true);
  const all = [...scene.objects.values()];
  const isFloor = (o) => /floor|ground|terrain/i.test(o.alias) || o.parts.some((p) => p.form === "plane");
  const shapes = all.filter((o) => o.kind === "shape" && !isFloor(o));
  const white = new THREE.MeshBasicMaterial({ color: 0xffffff, side: THREE.DoubleSide });
  const stage = new THREE.Scene();
  stage.background = new THREE.Color(0);
  const box = new THREE.Box3();
  for (const mesh of shapes.flatMap((o) => objects.groups.get(o.id).userData.bodies).filter((m) => m.visible)) {
    const copy = new THREE.Mesh(mesh.geometry, white);
    copy.matrixAutoUpdate = false;
    copy.matrix.copy(mesh.matrixWorld);
    stage.add(copy);
    const own = new THREE.Box3().setFromObject(mesh);
    if (own.max.length() < 1e3) box.union(own);
  }
  if (box.isEmpty()) return null;
  const to = box.getCenter(new THREE.Vector3());
  const radius = Math.max(0.1, box.getSize(new THREE.Vector3()).length() / 2);
  const from = to.clone().addScaledVector(new THREE.Vector3(0.55, -0.75, 0.5).normalize(), 2.6 * radius);
  const upward = (2 * Math.atan((Math.tan((25 * Math.PI) / 180) * HEIGHT) / WIDTH) * 180) / Math.PI;
  const camera = new THREE.PerspectiveCamera(upward, WIDTH / HEIGHT, Math.max(0.005, radius / 200), 50 * radius);
  camera.up.set(0, 0, 1);
  camera.position.copy(from);
  camera.lookAt(to);
  view.renderer.setPixelRatio(1);
  view.renderer.setSize(WIDTH, HEIGHT, false);
  view.renderer.render(stage, camera);
  const picture = view.renderer.domElement.toDataURL("image/png").split(",")[1];
  const path = async (o) => (await net.call("tatu.get", o.id, "object.path"))[0];
  const paths = (some) => Promise.all(some.map(path));
  const roots = await Promise.all(all.filter((o) => !o.parent).map(async (o) => [await path(o), o.pose]));
  const floors = await paths(all.filter((o) => o.kind === "shape" && isFloor(o)));
  return { picture, from: from.toArray(), to: to.toArray(), shapes: await paths(shapes), floors, roots };
})()""".replace("WIDTH", str(WIDTH)).replace("HEIGHT", str(HEIGHT))


class Page:
    """A page in a browser without a window."""

    def __init__(self, url):
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        args = ["--remote-debugging-port=0", "--remote-allow-origins=*", "--user-data-dir=" + self.folder.name]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.process = subprocess.Popen(BROWSER + args + ["about:blank"], **quiet)
        file = os.path.join(self.folder.name, "DevToolsActivePort")
        while not (os.path.exists(file) and open(file).read().strip()):
            time.sleep(0.1)
        port = open(file).read().split()[0]
        targets = json.load(urllib.request.urlopen("http://127.0.0.1:%s/json" % port))
        page = [t for t in targets if t["type"] == "page"][0]
        self.socket = websocket.create_connection(page["webSocketDebuggerUrl"])
        self.number = 0
        self.send("Page.navigate", url=url)

    def send(self, method, **params):
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": params}))
        while True:
            message = json.loads(self.socket.recv())
            if message.get("id") == self.number:
                return message.get("result", {})

    def value(self, expression):
        found = self.send("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        return found.get("result", {}).get("value")

    def close(self):
        self.socket.close()
        self.process.kill()
        self.process.wait()


def seen_in_page(program, scene):
    server = subprocess.Popen([program, "open", scene, "--no-browser"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    page = None
    try:
        page = Page(server.stdout.readline().strip())
        for _ in range(60):
            if page.value("import('tatu/scene/store').then((s) => s.scene.objects.size > 0)"):
                break
            time.sleep(0.5)
        time.sleep(1)
        return page.value(DRAW)
    finally:
        if page:
            page.close()
        server.kill()


def look(program, scene, seen, shown, file):
    up = lambda p: "%f,%f,%f" % (p[0], p[1], p[2] + UP)
    args = [program, "look", scene, "--from=" + up(seen["from"]), "--to=" + up(seen["to"]), "--fov", "50"]
    args += ["--size", "%dx%d" % (WIDTH, HEIGHT), "-o", file]
    for path, pose in seen["roots"]:
        args += ["--set", "%s.position_m=[%.9f,%.9f,%.9f]" % (path, pose[0], pose[1], pose[2] + UP)]
    for path in seen["floors"] + ([] if shown else seen["shapes"]):
        args += ["--set", path + ".visible=false"]
    subprocess.run(args, check=True, capture_output=True)
    return numpy.array(Image.open(file).convert("RGB")).astype(int)


def overlap(program, scene):
    seen = seen_in_page(program, scene)
    if not seen:
        return None
    picture = Image.open(io.BytesIO(base64.b64decode(seen["picture"]))).convert("L")
    page = numpy.array(picture) > 127
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "look.png")
        other = numpy.abs(look(program, scene, seen, True, file) - look(program, scene, seen, False, file)).max(axis=2) > 1
    return (page & other).sum() / max(1, (page | other).sum())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--program", default=os.path.join(HERE, "../../target/release/tatu"))
    args = parser.parse_args()
    for scene in args.scenes:
        share = overlap(args.program, scene)
        print("%-50s %s" % (os.path.basename(scene), "no shapes" if share is None else "%.3f" % share), flush=True)


if __name__ == "__main__":
    main()
