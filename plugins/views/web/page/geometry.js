// @ts-check
// Positions and turns as people read and type them. Nothing here needs a page.

/** @typedef {[number, number, number]} Vec3 */
/** @typedef {[number, number, number, number]} Quat x y z w */

const DEG = 180 / Math.PI;

/**
 * The nearest multiple of a step; a step of 0 leaves the number as it is.
 * @param {number} x
 * @param {number} step
 */
export function snap(x, step) {
  if (!(step > 0)) return x;
  const n = Math.round(x / step) * step;
  // Without the digits that the multiplication adds: 3 * 0.1 is 0.30000000000000004.
  return Number(n.toPrecision(12)) + 0;
}

/**
 * A quaternion as intrinsic rotations about x, then y, then z, in degrees, as scene files have them. Where x and z turn
 * about the same axis, x is 0.
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
 * The quaternion of angles in degrees about x, y and z; the inverse of `toDegrees`.
 * @param {Vec3} degrees
 * @returns {Quat}
 */
export function fromDegrees(degrees) {
  const [a, b, c] = [degrees[0] / DEG / 2, degrees[1] / DEG / 2, degrees[2] / DEG / 2];
  const [sx, sy, sz] = [Math.sin(a), Math.sin(b), Math.sin(c)];
  const [cx, cy, cz] = [Math.cos(a), Math.cos(b), Math.cos(c)];
  return [sx * cy * cz + cx * sy * sz, cx * sy * cz - sx * cy * sz, cx * cy * sz + sx * sy * cz, cx * cy * cz - sx * sy * sz];
}

/** @param {number} degrees */
function wrap(degrees) {
  return degrees > 180 ? degrees - 360 : degrees <= -180 ? degrees + 360 : degrees;
}

/**
 * Angles without the noise of their last digits, and without a negative zero.
 * @param {Vec3} angles
 * @returns {Vec3}
 */
function tidy([x, y, z]) {
  const one = (/** @type {number} */ a) => Math.round(a * 1e9) / 1e9 + 0;
  return [one(x), one(y), one(z)];
}

/**
 * A scan as triangles from the sensor to neighbouring beams. Beams come layer after layer, each in the order of its
 * angles, so a layer ends where the angle jumps back; layers are not joined.
 * @param {{ distance: (number | null)[], angle: number[], elevation?: number[], range?: number }} scan
 * @returns {{ points: number[], index: number[] }} three numbers for each point, the sensor first
 */
export function fan({ distance, angle, elevation, range }) {
  const longest = distance.reduce((/** @type {number} */ most, d) => Math.max(most, d ?? 0), 0);
  // A scanner without a limit has beams of some length that are seen to go on.
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
