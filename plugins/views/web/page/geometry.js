// @ts-check
// Calculates with positions, rotations and poses, and converts rotations for display and input. This module does not
// access the DOM, so it can be tested without a browser.

/** @typedef {[number, number, number]} Vec3 */
/** @typedef {[number, number, number, number]} Quat quaternion: x, y, z, w */

const DEG = 180 / Math.PI;

/**
 * Rounds a number to a multiple of a step; a step of 0 leaves it unchanged.
 * @param {number} x
 * @param {number} step
 */
export function snap(x, step) {
  if (!(step > 0)) return x;
  const n = Math.round(x / step) * step;
  // Removes rounding noise of the multiplication: 3 * 0.1 is 0.30000000000000004.
  return Number(n.toPrecision(12)) + 0;
}

/**
 * Converts a quaternion to intrinsic rotations about x, then y, then z, in degrees, as in scene files. In gimbal lock,
 * x is 0.
 * @param {Quat} q need not have length 1
 * @returns {Vec3}
 */
export function toDegrees(q) {
  const length = Math.hypot(...q);
  if (!(length > 0)) return [0, 0, 0];
  const [x, y, z, w] = [q[0] / length, q[1] / length, q[2] / length, q[3] / length];
  const s = 2 * (x * z + w * y);
  if (Math.abs(s) > 1 - 1e-12) {
    return tidy([0, s > 0 ? 90 : -90, wrap(2 * Math.atan2(z, w) * DEG)]);
  }
  return tidy([
    Math.atan2(2 * (w * x - y * z), 1 - 2 * (x * x + y * y)) * DEG,
    Math.asin(s) * DEG,
    Math.atan2(2 * (w * z - x * y), 1 - 2 * (y * y + z * z)) * DEG,
  ]);
}

/**
 * Converts intrinsic rotations about x, y and z to a quaternion: the inverse of `toDegrees`.
 * @param {Vec3} degrees
 * @returns {Quat}
 */
export function fromDegrees(degrees) {
  const [a, b, c] = [degrees[0] / DEG / 2, degrees[1] / DEG / 2, degrees[2] / DEG / 2];
  const [sx, sy, sz] = [Math.sin(a), Math.sin(b), Math.sin(c)];
  const [cx, cy, cz] = [Math.cos(a), Math.cos(b), Math.cos(c)];
  return [sx * cy * cz + cx * sy * sz, cx * sy * cz - sx * cy * sz, cx * cy * sz + sx * sy * cz, cx * cy * cz - sx * sy * sz];
}

/** Wraps an angle to the range (-180, 180]. @param {number} degrees */
function wrap(degrees) {
  return degrees > 180 ? degrees - 360 : degrees <= -180 ? degrees + 360 : degrees;
}

/**
 * Rounds angles to 1e-9, which removes floating-point noise, and replaces -0 by 0.
 * @param {Vec3} angles
 * @returns {Vec3}
 */
function tidy([x, y, z]) {
  const one = (/** @type {number} */ a) => Math.round(a * 1e9) / 1e9 + 0;
  return [one(x), one(y), one(z)];
}

/** @typedef {[number, number, number, number, number, number, number]} Pose position, then quaternion x, y, z, w */

/** The identity pose. @type {Pose} */
export const STILL = [0, 0, 0, 0, 0, 0, 1];

/**
 * Returns the position of a pose.
 * @param {Pose} pose
 * @returns {Vec3}
 */
export function positionOf([x, y, z]) {
  return [x, y, z];
}

/**
 * Returns the rotation of a pose.
 * @param {Pose} pose
 * @returns {Quat}
 */
export function rotationOf([, , , x, y, z, w]) {
  return [x, y, z, w];
}

/**
 * Returns the product of two rotations; the second one is applied first.
 * @param {Quat} a
 * @param {Quat} b
 * @returns {Quat}
 */
export function multiply([x, y, z, w], [a, b, c, d]) {
  return [w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c];
}

/**
 * Returns the inverse of a rotation.
 * @param {Quat} q of length 1
 * @returns {Quat}
 */
export function conjugate([x, y, z, w]) {
  return [-x + 0, -y + 0, -z + 0, w];
}

/**
 * Rotates a vector.
 * @param {Quat} q of length 1
 * @param {Vec3} v
 * @returns {Vec3}
 */
export function rotate([x, y, z, w], [a, b, c]) {
  const [tx, ty, tz] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

/**
 * @param {Vec3} a
 * @param {Vec3} b
 * @returns {Vec3}
 */
export function plus([a, b, c], [x, y, z]) {
  return [a + x, b + y, c + z];
}

/**
 * @param {Vec3} a
 * @param {Vec3} b
 * @returns {Vec3}
 */
export function minus([a, b, c], [x, y, z]) {
  return [a - x, b - y, c - z];
}

/**
 * @param {Vec3} a
 * @param {Vec3} b
 */
export function dot([a, b, c], [x, y, z]) {
  return a * x + b * y + c * z;
}

/**
 * @param {Vec3} a
 * @param {Vec3} b
 * @returns {Vec3}
 */
export function cross([a, b, c], [x, y, z]) {
  return [b * z - c * y, c * x - a * z, a * y - b * x];
}

/**
 * Composes two poses: `inner` is relative to `outer`.
 * @param {Pose} outer
 * @param {Pose} inner
 * @returns {Pose}
 */
export function compose(outer, inner) {
  const q = rotationOf(outer);
  return [...plus(positionOf(outer), rotate(q, positionOf(inner))), ...multiply(q, rotationOf(inner))];
}

/**
 * Returns the inverse of a pose.
 * @param {Pose} pose
 * @returns {Pose}
 */
export function inverse(pose) {
  const q = conjugate(rotationOf(pose));
  return [...rotate(q, minus([0, 0, 0], positionOf(pose))), ...q];
}

/** @typedef {"world" | "parent" | "own"} Frame the world frame, or that of an object's parent or of the object itself */

/**
 * Returns the pose, in the world frame, of a frame of an object.
 * @param {Frame} frame
 * @param {{ world: Pose, local: Pose }} of the pose of an object in the world, and in the frame of its parent
 * @returns {Pose}
 */
export function frameOf(frame, { world, local }) {
  if (frame === "world") return STILL;
  return frame === "own" ? world : compose(world, inverse(local));
}

/**
 * Returns the motion in the world frame for a translation along the axes of a frame.
 * @param {Pose} frame
 * @param {Vec3} by displacement in `frame`
 * @returns {Pose}
 */
export function shift(frame, by) {
  return [...rotate(rotationOf(frame), by), 0, 0, 0, 1];
}

/**
 * Returns the motion in the world frame for a rotation about a point.
 * @param {Pose} frame
 * @param {Quat} by rotation in `frame`
 * @param {Vec3} about the point in the world frame
 * @returns {Pose}
 */
export function spin(frame, by, about) {
  const q = multiply(multiply(rotationOf(frame), by), conjugate(rotationOf(frame)));
  return [...minus(about, rotate(q, about)), ...q];
}

/**
 * Returns the pose of an object in the frame of its parent after a motion in the world frame.
 * @param {Pose} motion
 * @param {{ world: Pose, local: Pose }} from the poses before the motion, in the world and in the frame of the parent
 * @returns {Pose}
 */
export function moved(motion, { world, local }) {
  const [x, y, z, ...q] = compose(compose(local, inverse(world)), compose(motion, world));
  const length = Math.hypot(...q) || 1;
  // Rounding removes floating-point noise, so that an object placed at 0.6 is exactly at 0.6.
  const one = (/** @type {number} */ a) => Math.round(a * 1e12) / 1e12 + 0;
  const [a, b, c, d] = q;
  return [one(x), one(y), one(z), one(a / length), one(b / length), one(c / length), one(d / length)];
}

/**
 * Returns a rotation about one axis.
 * @param {number} axis 0: x; 1: y; 2: z
 * @param {number} degrees
 */
export function about(axis, degrees) {
  /** @type {Vec3} */
  const angles = [0, 0, 0];
  angles[axis] = degrees;
  return fromDegrees(angles);
}

/** @typedef {{ axis: number, sign: number }} Way a direction: the index of an axis, and 1 or -1 along it */

/**
 * Returns which of the x and y axes of a frame, and in which direction, is closest to the right on the screen
 * (`across`) and to the direction away from the camera (`ahead`).
 * @param {Quat} frame the rotation of the frame in the world
 * @param {Vec3} right the direction to the right on the screen
 * @param {Vec3} away a direction that is up on the screen or away from the camera
 * @returns {{ across: Way, ahead: Way }}
 */
export function screenAxes(frame, right, away) {
  const [x, y] = [rotate(frame, [1, 0, 0]), rotate(frame, [0, 1, 0])];
  const across = Math.abs(dot(x, right)) >= Math.abs(dot(y, right)) ? 0 : 1;
  const sign = (/** @type {Vec3} */ axis, /** @type {Vec3} */ way) => (dot(axis, way) < 0 ? -1 : 1);
  return {
    across: { axis: across, sign: sign(across ? y : x, right) },
    ahead: { axis: 1 - across, sign: sign(across ? x : y, away) },
  };
}

/**
 * Converts a scan to triangles between the sensor and neighbouring beams. Beams are ordered by layer and, within a
 * layer, by angle, so a new layer starts where the angle decreases. Layers are not joined.
 * @param {{ distance: (number | null)[], angle: number[], elevation?: number[], range?: number }} scan
 * @returns {{ points: number[], index: number[] }} the coordinates of the points, the sensor first, and the indices of the
 *   points of the triangles
 */
export function fan({ distance, angle, elevation, range }) {
  const longest = distance.reduce((/** @type {number} */ most, d) => Math.max(most, d ?? 0), 0);
  // If the range is unlimited, beams without a hit are drawn as long as the longest one with a hit, or 10 m.
  const free = range ?? (longest || 10);
  const points = [0, 0, 0];
  /** @type {number[]} */
  const index = [];
  distance.forEach((d, i) => {
    const [length, a, e] = [d ?? free, angle[i] ?? 0, elevation?.[i] ?? 0];
    points.push(Math.sin(a) * Math.cos(e) * length, Math.sin(e) * length, Math.cos(a) * Math.cos(e) * length);
    if (i > 0 && (angle[i] ?? 0) >= (angle[i - 1] ?? 0)) index.push(0, i, i + 1);
  });
  return { points, index };
}

/**
 * Computes the principal moments of an inertia matrix and its right-handed principal axes, by Jacobi rotations.
 * @param {number[]} inertia the nine elements in row-major order
 * @returns {{ moments: Vec3, axes: [Vec3, Vec3, Vec3] }}
 */
export function principal(inertia) {
  const a = [0, 1, 2].map((i) => [0, 1, 2].map((j) => inertia[3 * i + j] ?? 0));
  const v = [0, 1, 2].map((i) => [0, 1, 2].map((j) => (i === j ? 1 : 0)));
  const at = (/** @type {number[][]} */ m, /** @type {number} */ i, /** @type {number} */ j) => m[i]?.[j] ?? 0;
  const turn = (/** @type {number[][]} */ m, /** @type {number} */ p, /** @type {number} */ q, /** @type {number} */ c, /** @type {number} */ s) => {
    for (const row of m) {
      const [x, y] = [row[p] ?? 0, row[q] ?? 0];
      row[p] = c * x - s * y;
      row[q] = s * x + c * y;
    }
  };
  const transposed = (/** @type {number[][]} */ m) => [0, 1, 2].map((i) => [0, 1, 2].map((j) => at(m, j, i)));
  let m = a;
  for (let sweep = 0; sweep < 20; sweep++) {
    for (const [p, q] of /** @type {const} */ ([[0, 1], [0, 2], [1, 2]])) {
      if (Math.abs(at(m, p, q)) < 1e-300) continue;
      const angle = 0.5 * Math.atan2(2 * at(m, p, q), at(m, q, q) - at(m, p, p));
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      turn(m, p, q, c, s);
      m = transposed(m);
      turn(m, p, q, c, s);
      turn(v, p, q, c, s);
    }
  }
  const axis = (/** @type {number} */ j) => /** @type {Vec3} */ ([at(v, 0, j), at(v, 1, j), at(v, 2, j)]);
  return { moments: [at(m, 0, 0), at(m, 1, 1), at(m, 2, 2)], axes: [axis(0), axis(1), axis(2)] };
}
