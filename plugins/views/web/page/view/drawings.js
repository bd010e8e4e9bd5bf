// @ts-check
// Draws the drawing objects of scripts in the 3-D view, and the streams of the selected graph beside its properties.

import * as THREE from "three";
import { get } from "tatu/lib/dom";
import { plot } from "tatu/lib/plot";
import { on } from "tatu/net/connection";
import { selected } from "tatu/scene/store";
import { sceneMaterial } from "tatu/view/light";
import { redraw, stage } from "tatu/view/renderer";

/** @import { Drawing } from "tatu/protocol" */

const drawingGroup = new THREE.Group();
stage.add(drawingGroup);

/** Creates the three.js object that represents a drawing object. @param {Drawing} d */
function drawing(d) {
  const [red = 1, green = 0, blue = 0] = d.color;
  const color = new THREE.Color().setRGB(red, green, blue, THREE.SRGBColorSpace);
  const { form, items, stride } = d;
  /** @type {number[][]} */
  const points = [];
  if (stride < 3) return new THREE.Group();
  for (let i = 0; i + stride <= items.length; i += stride) points.push(items.slice(i, i + stride));
  const at = (/** @type {number[]} */ p, k = 0) => new THREE.Vector3().fromArray(p, k);
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
    const material = new THREE.PointsMaterial({ color, size: Math.max(3, d.size), sizeAttenuation: false });
    return new THREE.Points(new THREE.BufferGeometry().setFromPoints(points.map((p) => at(p))), material);
  }
  const shape = form.startsWith("cube") ? new THREE.BoxGeometry(1, 1, 1) : new THREE.SphereGeometry(0.5, 12, 8);
  const mesh = new THREE.InstancedMesh(shape, sceneMaterial({ color }), points.length);
  const size = d.size || 0.02;
  points.forEach((p, i) => mesh.setMatrixAt(i, new THREE.Matrix4().makeScale(size, size, size).setPosition(at(p))));
  return mesh;
}

on("drawings", ({ drawings }) => {
  drawingGroup.traverse((x) => {
    if (x instanceof THREE.Mesh || x instanceof THREE.Line || x instanceof THREE.Points) x.geometry.dispose();
  });
  drawingGroup.clear();
  for (const d of drawings) drawingGroup.add(drawing(d));
  redraw();
});

const canvas = get("plot", HTMLCanvasElement);
on("streams", ({ graph, streams }) => { if (graph === selected()) plot(canvas, streams); });
