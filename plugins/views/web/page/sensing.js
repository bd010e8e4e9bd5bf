// What sensors sense: beams to what was seen, fans of scans, images, places of GPS.

import * as THREE from "three";
import { hang, isLarge } from "tatu/crowd";
import { on } from "tatu/net";
import { groups } from "tatu/objects";
import { scene, selected } from "tatu/store";
import { redraw } from "tatu/view";

const SEEN = new THREE.LineBasicMaterial({ color: 0xe0352b });
const FREE = new THREE.LineBasicMaterial({ color: 0x2a9d5c, transparent: true, opacity: 0.35 });
const POINT = new THREE.PointsMaterial({ color: 0xe0352b, size: 6, sizeAttenuation: false });
const PLACE = new THREE.PointsMaterial({ color: 0x8a3ffc, size: 9, sizeAttenuation: false, depthTest: false });
const FAN = new THREE.MeshBasicMaterial({ color: 0x2b7de0, transparent: true, opacity: 0.22, side: THREE.DoubleSide, depthWrite: false });
const rays = document.getElementById("rays");
const drawn = new Map();

function replace(id, parts) {
  const group = groups.get(id);
  drawn.get(id)?.removeFromParent();
  drawn.get(id)?.traverse((x) => x.geometry?.dispose());
  drawn.delete(id);
  if (!group || !parts) return;
  const own = new THREE.Group();
  own.add(...parts);
  drawn.set(id, own);
  hang(group, own);
}

const lines = (points, material) => new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), material);
const O = new THREE.Vector3();

function proximity(r) {
  if (!r.detected) return [lines([O, new THREE.Vector3(0, 0, 0.15)], FREE)];
  const at = new THREE.Vector3(...r.point);
  return [lines([O, at], SEEN), new THREE.Points(new THREE.BufferGeometry().setFromPoints([at]), POINT)];
}

/** A fan of triangles between neighbouring beams. */
function scan(r) {
  const points = [0, 0, 0];
  const index = [];
  r.distance.forEach((d, i) => {
    const a = r.angle[i] ?? 0;
    const length = d ?? 0;
    points.push(Math.sin(a) * length, 0, Math.cos(a) * length);
    if (i) index.push(0, i, i + 1);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  geometry.setIndex(index);
  return [new THREE.Mesh(geometry, FAN)];
}

/** Where a receiver says that it is, and the way from where it is. */
function gps(group, r) {
  const there = group.worldToLocal(new THREE.Vector3(...r.position));
  return [lines([O, there], FREE), new THREE.Points(new THREE.BufferGeometry().setFromPoints([there]), PLACE)];
}

on("readings", ({ readings }) => {
  for (const [key, r] of Object.entries(readings)) {
    const id = Number(key);
    const schema = scene.objects.get(id)?.schema;
    // Of large scenes only what the selected sensor sees is drawn.
    if (!rays.checked || (isLarge() && id !== selected())) replace(id, null);
    else if (schema === "proximity") replace(id, proximity(r));
    else if (schema === "gps") replace(id, gps(groups.get(id), r));
    else if (schema === "range_scan" && r.distance.length) replace(id, scan(r));
  }
  redraw();
});

const canvas = document.getElementById("eye");
/** An image of a sensor, the lowest row first. */
on("image", (view) => {
  if (view.getUint32(4, true) !== selected()) return;
  const [w, h] = [view.getUint32(8, true), view.getUint32(12, true)];
  canvas.width = w;
  canvas.height = h;
  const image = new ImageData(w, h);
  const color = view.getUint8(2) === 0;
  let far = 0;
  if (!color) for (let i = 0; i < w * h; i++) far = Math.max(far, finite(view.getFloat32(16 + 4 * i, true)));
  for (let y = 0; y < h; y++) {
    for (let x = 0; x < w; x++) {
      const from = y * w + x;
      const to = 4 * ((h - 1 - y) * w + x);
      for (let c = 0; c < 3; c++) {
        image.data[to + c] = color ? view.getUint8(16 + 3 * from + c) : 255 * (1 - finite(view.getFloat32(16 + 4 * from, true)) / (far || 1));
      }
      image.data[to + 3] = 255;
    }
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
});

function finite(x) {
  return Number.isFinite(x) ? x : 0;
}
