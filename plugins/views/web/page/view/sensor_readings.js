// @ts-check
// Draws readings of sensors: in the view, beams to detected points, fans of scans, and GPS positions; beside the
// properties, the image of the selected sensor.

import * as THREE from "three";
import { get } from "tatu/lib/dom";
import { parseImage } from "tatu/net/binary_messages";
import { on } from "tatu/net/connection";
import { scene, selected, showsDepth, watch } from "tatu/scene/store";
import { attachTo, isLarge } from "tatu/view/instancing";
import { groups } from "tatu/view/objects";
import { redraw } from "tatu/view/renderer";
import { scanSurface } from "tatu/view/scan_surface";
import { volumeGeometry } from "tatu/view/volume_geometry";

/** @import { Reading } from "tatu/protocol" */
/** @typedef {Extract<Reading, { schema: "proximity" }>} Proximity */
/** @typedef {Extract<Reading, { schema: "range_scan" }>} Scan */
/** @typedef {Extract<Reading, { schema: "gps" }>} Place */

const HIT_MATERIAL = new THREE.LineBasicMaterial({ color: 0xe0352b });
const FREE_MATERIAL = new THREE.LineBasicMaterial({ color: 0x2a9d5c, transparent: true, opacity: 0.35 });
/** Colors of the cones of proximity sensors. */
const HIT_CONE_MATERIAL = new THREE.MeshBasicMaterial({ color: 0xe0352b, transparent: true, opacity: 0.14, side: THREE.DoubleSide, depthWrite: false });
const FREE_CONE_MATERIAL = new THREE.MeshBasicMaterial({ color: 0x2a9d5c, transparent: true, opacity: 0.05, side: THREE.DoubleSide, depthWrite: false });
const POINT_MATERIAL = new THREE.PointsMaterial({ color: 0xe0352b, size: 6, sizeAttenuation: false });
const POSITION_MATERIAL = new THREE.PointsMaterial({ color: 0x8a3ffc, size: 9, sizeAttenuation: false, depthTest: false });
const SCAN_MATERIAL = new THREE.MeshBasicMaterial({ color: 0x2b7de0, transparent: true, opacity: 0.22, side: THREE.DoubleSide, depthWrite: false });
const raysBox = get("rays", HTMLInputElement);
/** The drawing of each sensor, by handle. @type {Map<number, THREE.Group>} */
const drawings = new Map();
/** The last reading of each sensor, by handle. @type {Map<number, Reading>} */
const lastReadings = new Map();

/** Removes the drawing of a sensor. @param {number} id */
function erase(id) {
  const old = drawings.get(id);
  old?.removeFromParent();
  old?.traverse((x) => {
    if (x instanceof THREE.Mesh || x instanceof THREE.Line || x instanceof THREE.Points) x.geometry.dispose();
  });
  drawings.delete(id);
}

/**
 * Creates a line through points.
 * @param {THREE.Vector3[]} points
 * @param {THREE.LineBasicMaterial} material
 */
const lines = (points, material) => new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), material);
const ORIGIN = new THREE.Vector3();

/**
 * Creates the cone of a proximity sensor, up to the distance of what it detects, and the detected point. Sensors with
 * another volume have a line instead of the cone.
 * @param {number} id
 * @param {Proximity} r
 */
function proximity(id, r) {
  const volume = scene.objects.get(id)?.volume;
  const cone = volume?.volume === "cone" && (volume.angle ?? 0) > 0 ? volume : null;
  if (!r.detected || !r.point) {
    const surface = cone && volumeGeometry(cone);
    return [surface ? new THREE.Mesh(surface, FREE_CONE_MATERIAL) : lines([ORIGIN, new THREE.Vector3(0, 0, 0.15)], FREE_MATERIAL)];
  }
  const at = new THREE.Vector3().fromArray(r.point);
  const point = new THREE.Points(new THREE.BufferGeometry().setFromPoints([at]), POINT_MATERIAL);
  const surface = cone && volumeGeometry({ ...cone, range: at.length() });
  return surface ? [new THREE.Mesh(surface, HIT_CONE_MATERIAL), lines([ORIGIN, at], HIT_MATERIAL), point] : [lines([ORIGIN, at], HIT_MATERIAL), point];
}

/**
 * Creates a fan of triangles between neighbouring beams of a scan.
 * @param {Scan} r
 */
function scan(r) {
  const { points, index } = scanSurface(r);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  geometry.setIndex(index);
  return [new THREE.Mesh(geometry, SCAN_MATERIAL)];
}

/**
 * Creates a point at the measured position of a GPS receiver, and a line to it from the true position.
 * @param {THREE.Object3D} group
 * @param {Place} r
 */
function gps(group, r) {
  const position = group.worldToLocal(new THREE.Vector3().fromArray(r.position));
  return [lines([ORIGIN, position], FREE_MATERIAL), new THREE.Points(new THREE.BufferGeometry().setFromPoints([position]), POSITION_MATERIAL)];
}

/**
 * Creates the drawing of a reading.
 * @param {number} id
 * @param {THREE.Object3D} group
 * @param {Reading} r
 */
function drawingOf(id, group, r) {
  switch (r.schema) {
    case "proximity": return proximity(id, r);
    case "range_scan": return scan(r);
    case "gps": return gps(group, r);
    case "fields": return [];
  }
}

/** Draws the last reading of a sensor. @param {number} id */
function draw(id) {
  erase(id);
  const [group, reading] = [groups.get(id), lastReadings.get(id)];
  // In large scenes, only the reading of the selected sensor is drawn.
  if (!group || !reading || !raysBox.checked || (isLarge() && id !== selected())) return;
  const drawing = new THREE.Group();
  drawing.add(...drawingOf(id, group, reading));
  drawings.set(id, drawing);
  attachTo(group, drawing);
}

/** Redraws all readings. */
function drawAll() {
  for (const id of new Set([...drawings.keys(), ...lastReadings.keys()])) draw(id);
  redraw();
}

on("readings", ({ readings }) => {
  for (const [key, reading] of Object.entries(readings)) {
    const id = Number(key);
    if (reading) lastReadings.set(id, reading);
    else lastReadings.delete(id);
    draw(id);
  }
  redraw();
});
// Readings from an earlier scene or from before a reset are no longer valid.
watch("scene", () => {
  lastReadings.clear();
  drawAll();
});
on("event", ({ name }) => {
  if (name !== "stopped") return;
  lastReadings.clear();
  drawAll();
});
watch("selected", () => { if (isLarge()) drawAll(); });
raysBox.onchange = drawAll;

const canvas = get("eye", HTMLCanvasElement);
/** Handle of the sensor of which the last image with colors was. */
let coloredSensor = 0;
on("image", (view) => {
  const { id, isDepth, width, height, pixels } = parseImage(view);
  const o = scene.objects.get(id);
  if (id !== selected() || !width || !height) return;
  // A window may show the other image of the sensor. Some sensors do not measure their colors.
  if (!isDepth) coloredSensor = id;
  if (showsDepth(o) ? !isDepth : isDepth && coloredSensor === id) return;
  canvas.width = width;
  canvas.height = height;
  canvas.getContext("2d")?.putImageData(new ImageData(pixels, width, height), 0, 0);
});
