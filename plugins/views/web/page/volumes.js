// The volume in which the selected sensor senses; it lights up when something is in it.

import * as THREE from "three";
import { hang } from "tatu/crowd";
import { on } from "tatu/net";
import { groups } from "tatu/objects";
import { scene, selected, watch } from "tatu/store";
import { redraw } from "tatu/view";

const FREE = 0x2a9d5c;
const SEEN = 0xe0352b;
const fill = new THREE.MeshBasicMaterial({ color: FREE, transparent: true, opacity: 0.18, side: THREE.DoubleSide, depthWrite: false });
const edge = new THREE.LineBasicMaterial({ color: FREE, transparent: true, opacity: 0.6 });

/** From the near face to the far one, along z: each has half a width and half a height. */
function between(near, from, far, to, sides) {
  const geometry = new THREE.CylinderGeometry(1, 1, 1, sides, 1, true, sides === 4 ? Math.PI / 4 : 0).rotateX(Math.PI / 2);
  const scale = sides === 4 ? Math.SQRT2 : 1;
  const p = geometry.getAttribute("position");
  for (let i = 0; i < p.count; i++) {
    const end = p.getZ(i) > 0;
    const [w, h] = end ? far : near;
    p.setXYZ(i, p.getX(i) * w * scale, p.getY(i) * h * scale, end ? to : from);
  }
  return geometry;
}

/** A part of a ball about the sensor, as far as it senses. */
function cone({ range, near = 0, angle = 0 }) {
  const half = Math.min(angle / 2, Math.PI);
  const points = [];
  for (let i = 0; i <= 8; i++) points.push(new THREE.Vector2(Math.sin((half * i) / 8) * range, Math.cos((half * i) / 8) * range));
  points.push(new THREE.Vector2(Math.sin(half) * near, Math.cos(half) * near));
  return new THREE.LatheGeometry(points, 24).rotateX(Math.PI / 2);
}

function geometry(v) {
  const [range, near] = [v.range ?? 0, v.near ?? 0];
  if (!(range > 0)) return null;
  switch (v.volume) {
    case "cone": return cone(v);
    case "pyramid": return between(v.size_near.map((x) => x / 2), near, v.size_far.map((x) => x / 2), range, 4);
    case "cylinder": return between([v.radius_near, v.radius_near], near, [v.radius_far, v.radius_far], range, 24);
    default: return null;
  }
}

let shown = null;
watch("selected", (id) => {
  shown?.removeFromParent();
  shown?.traverse((x) => x.geometry?.dispose());
  shown = null;
  const group = groups.get(id);
  const form = group && geometry(scene.objects.get(id)?.volume ?? {});
  if (!form) return;
  shown = new THREE.Group();
  shown.add(new THREE.Mesh(form, fill), new THREE.LineSegments(new THREE.EdgesGeometry(form, 30), edge));
  hang(group, shown);
  redraw();
});
on("readings", ({ readings }) => {
  const own = readings[selected()];
  if (!own || !shown) return;
  for (const material of [fill, edge]) material.color.setHex(own.detected ? SEEN : FREE);
});
