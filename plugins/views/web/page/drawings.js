// What scripts draw in space, and graphs.

import * as THREE from "three";
import { plot } from "tatu/plot";
import { on } from "tatu/net";
import { selected } from "tatu/store";
import { redraw, stage } from "tatu/view";

const all = new THREE.Group();
stage.add(all);

function drawing(d) {
  const color = new THREE.Color().setRGB(...(d.color ?? [1, 0, 0]).slice(0, 3), THREE.SRGBColorSpace);
  const { items = [], stride = 3 } = d;
  const points = [];
  for (let i = 0; i + stride <= items.length; i += stride) points.push(items.slice(i, i + stride));
  const at = (p, k = 0) => new THREE.Vector3(p[k], p[k + 1], p[k + 2]);
  const form = String(d.form);
  if (form.startsWith("line_strip")) {
    return new THREE.Line(new THREE.BufferGeometry().setFromPoints(points.map((p) => at(p))), new THREE.LineBasicMaterial({ color }));
  }
  if (form.startsWith("line")) {
    const ends = points.flatMap((p) => [at(p), at(p, 3)]);
    return new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(ends), new THREE.LineBasicMaterial({ color }));
  }
  if (form.startsWith("triangle") && stride >= 9) {
    const geometry = new THREE.BufferGeometry().setFromPoints(points.flatMap((p) => [at(p), at(p, 3), at(p, 6)]));
    return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color, side: THREE.DoubleSide }));
  }
  if (form.startsWith("point")) {
    const material = new THREE.PointsMaterial({ color, size: Math.max(3, d.size ?? 3), sizeAttenuation: false });
    return new THREE.Points(new THREE.BufferGeometry().setFromPoints(points.map((p) => at(p))), material);
  }
  const shape = form.startsWith("cube") ? new THREE.BoxGeometry(1, 1, 1) : new THREE.SphereGeometry(0.5, 12, 8);
  const mesh = new THREE.InstancedMesh(shape, new THREE.MeshLambertMaterial({ color }), points.length);
  const size = d.size || 0.02;
  points.forEach((p, i) => mesh.setMatrixAt(i, new THREE.Matrix4().makeScale(size, size, size).setPosition(...p.slice(0, 3))));
  return mesh;
}

on("drawings", ({ drawings }) => {
  all.traverse((x) => x.geometry?.dispose());
  all.clear();
  for (const d of drawings) all.add(drawing(d));
  redraw();
});

const canvas = document.getElementById("plot");
on("streams", ({ graph, streams }) => { if (graph === selected()) plot(canvas, streams); });
