// What scripts draw in space, and graphs.

import * as THREE from "three";
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
on("streams", ({ graph, streams }) => {
  if (graph !== selected()) return;
  const c = canvas.getContext("2d");
  const [w, h] = [canvas.width, canvas.height];
  c.clearRect(0, 0, w, h);
  const values = streams.flatMap((s) => s.values.filter((x) => x !== null));
  const times = streams.flatMap((s) => s.times);
  if (!values.length) return;
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const [from, to] = [Math.min(...times), Math.max(...times)];
  const x = (t) => 34 + ((w - 40) * (t - from)) / (to - from || 1);
  const y = (v) => h - 16 - ((h - 30) * (v - low)) / (high - low || 1);
  c.font = "11px sans-serif";
  c.fillStyle = getComputedStyle(canvas).color;
  c.fillText(high.toPrecision(3), 0, 12);
  c.fillText(low.toPrecision(3), 0, h - 16);
  c.fillText(`${from.toFixed(1)} s`, 34, h - 2);
  c.fillText(`${to.toFixed(1)} s`, w - 40, h - 2);
  streams.forEach((s, i) => {
    const [r, g, b] = (s.color ?? [0.2, 0.5, 0.9]).map((v) => Math.round(255 * v));
    c.strokeStyle = c.fillStyle = `rgb(${r} ${g} ${b})`;
    c.beginPath();
    s.values.forEach((v, k) => { if (v !== null) c.lineTo(x(s.times[k]), y(v)); });
    c.stroke();
    c.fillText(`${s.name} ${s.unit ? `(${s.unit})` : ""}`, 40, 12 + 12 * i);
  });
});
