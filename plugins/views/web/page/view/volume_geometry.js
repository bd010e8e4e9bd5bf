// @ts-check
// The surfaces of the detection volumes of sensors, in the frame of the sensor.

import * as THREE from "three";

/** @import { SensorVolume } from "tatu/protocol" */

/**
 * Returns the lateral surface between two faces perpendicular to the z axis.
 * @param {[number, number]} near half the width and height of the near face, m
 * @param {number} from z of the near face, m
 * @param {[number, number]} far half the width and height of the far face, m
 * @param {number} to z of the far face, m
 * @param {number} sides 4 for rectangular faces; otherwise, faces are approximated ellipses
 */
function lateralSurface(near, from, far, to, sides) {
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

/**
 * Returns the surface of a conical section of a sphere around the sensor. Its radius is the range of the sensor.
 * @param {SensorVolume} volume
 */
function cone({ range = 0, near = 0, angle = 0 }) {
  const half = Math.min(angle / 2, Math.PI);
  const points = [];
  for (let i = 0; i <= 8; i++) points.push(new THREE.Vector2(Math.sin((half * i) / 8) * range, Math.cos((half * i) / 8) * range));
  points.push(new THREE.Vector2(Math.sin(half) * near, Math.cos(half) * near));
  return new THREE.LatheGeometry(points, 24).rotateX(Math.PI / 2);
}

/**
 * Returns half the width and height of a face.
 * @param {[number, number]} [size]
 * @returns {[number, number]}
 */
function half([w, h] = [0, 0]) {
  return [w / 2, h / 2];
}

/** Returns the surface of a volume, or null if it cannot be drawn. @param {SensorVolume} v */
export function volumeGeometry(v) {
  const [range, near] = [v.range ?? 0, v.near ?? 0];
  if (!(range > 0)) return null;
  switch (v.volume) {
    case "cone": return cone(v);
    case "pyramid": return lateralSurface(half(v.size_near), near, half(v.size_far), range, 4);
    case "cylinder": {
      const [from, to] = [v.radius_near ?? 0, v.radius_far ?? 0];
      return lateralSurface([from, from], near, [to, to], range, 24);
    }
    default: return null;
  }
}
