// @ts-check
// The manipulability ellipsoid of an object that joints move: its radii are the velocities that the object can have in
// each direction when the joints move at 1 rad/s or 1 m/s together (the root of the sum of the squares).

import * as THREE from "three";
import { principal } from "tatu/lib/inertia";
import { sendLatest } from "tatu/net/calls";
import { call } from "tatu/net/connection";
import { scene } from "tatu/scene/store";
import { groups } from "tatu/view/objects";

/** @import { Vec3 } from "tatu/lib/vectors" */
/** @typedef {{ id: number, radii: Vec3, axes: [Vec3, Vec3, Vec3] }} Ellipsoid In the world frame; radii in m/s. */

/** Number of columns of a base that is not fixed. */
const BASE_COLUMNS = 6;
/** Segments of each of the three ellipses that are drawn. */
const SEGMENTS = 48;

/**
 * Returns the object below which all joints of the mechanism of an object are: the base of its model, or the topmost
 * object.
 * @param {number} id
 */
function baseOf(id) {
  let base = id;
  for (let at = scene.objects.get(id); at; at = scene.objects.get(at.parent)) {
    base = at.id;
    if (at.model && at.id !== id) break;
  }
  return base;
}

/**
 * Returns the ellipsoid of an object, or null if no joint moves it. The motion of a base that is not fixed is ignored.
 * @param {number} id
 * @returns {Promise<Ellipsoid | null>}
 */
async function ellipsoidOf(id) {
  const base = baseOf(id);
  const [[joints, , columns], [jacobian]] = await Promise.all([call("tatu.kin.joints", base), call("tatu.kin.jacobian", base, id)]);
  const first = joints.length > 1 && columns[1] === BASE_COLUMNS + 1 ? BASE_COLUMNS : 0;
  /** @type {number[][]} */
  const rows = jacobian.slice(0, 3).map((/** @type {number[]} */ row) => row.slice(first));
  const squares = rows.flatMap((a) => rows.map((b) => a.reduce((sum, x, k) => sum + x * (b[k] ?? 0), 0)));
  const { moments, axes } = principal(squares);
  const radii = /** @type {Vec3} */ (moments.map((x) => Math.sqrt(Math.max(0, x))));
  return Math.max(...radii) > 1e-9 ? { id, radii, axes } : null;
}

/** @type {Ellipsoid | null} */
let ellipsoid = null;

const request = sendLatest(async (/** @type {{ id: number, done: () => void }} */ { id, done }) => {
  // An object that no joint moves has no ellipsoid.
  const found = id ? await ellipsoidOf(id).catch(() => null) : null;
  const changed = JSON.stringify(found) !== JSON.stringify(ellipsoid);
  ellipsoid = found;
  if (changed) done();
});

/**
 * Requests the ellipsoid of an object, 0: none, and calls `done` if it has changed.
 * @param {number} id
 * @param {() => void} done
 */
export function requestEllipsoid(id, done) {
  request({ id, done });
}

/**
 * Returns the ends of line segments that show the last ellipsoid: its three principal ellipses and its axes.
 * @param {number} size length of the largest radius, m
 * @returns {THREE.Vector3[]}
 */
export function ellipsoidSegments(size) {
  const group = ellipsoid ? groups.get(ellipsoid.id) : null;
  if (!ellipsoid || !group) return [];
  const center = group.getWorldPosition(new THREE.Vector3());
  const scale = size / Math.max(...ellipsoid.radii);
  const { axes, radii } = ellipsoid;
  const half = axes.map((axis, i) => new THREE.Vector3(...axis).multiplyScalar(scale * (radii[i] ?? 0)));
  /** @type {THREE.Vector3[]} */
  const ends = [];
  for (const [i, j] of /** @type {const} */ ([[0, 1], [1, 2], [2, 0]])) {
    const [a, b] = [half[i] ?? center, half[j] ?? center];
    const at = (/** @type {number} */ k) => {
      const angle = (2 * Math.PI * k) / SEGMENTS;
      return center.clone().addScaledVector(a, Math.cos(angle)).addScaledVector(b, Math.sin(angle));
    };
    for (let k = 0; k < SEGMENTS; k++) ends.push(at(k), at(k + 1));
  }
  for (const axis of half) ends.push(center.clone().sub(axis), center.clone().add(axis));
  return ends;
}
