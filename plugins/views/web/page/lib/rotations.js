// @ts-check
// Calculates with rotations, and converts them for display and input. This module does not access the DOM, so it can be
// tested without a browser.

import { dot } from "./vectors.js";

/** @import { Vec3 } from "tatu/lib/vectors" */
/** @typedef {[number, number, number, number]} Quat quaternion: x, y, z, w */

const DEG = 180 / Math.PI;

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
    return roundAngles([0, s > 0 ? 90 : -90, wrapAngle(2 * Math.atan2(z, w) * DEG)]);
  }
  return roundAngles([
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
function wrapAngle(degrees) {
  return degrees > 180 ? degrees - 360 : degrees <= -180 ? degrees + 360 : degrees;
}

/**
 * Rounds angles to 1e-9, which removes floating-point noise, and replaces -0 by 0.
 * @param {Vec3} angles
 * @returns {Vec3}
 */
function roundAngles([x, y, z]) {
  const one = (/** @type {number} */ a) => Math.round(a * 1e9) / 1e9 + 0;
  return [one(x), one(y), one(z)];
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
 * Returns a rotation about one axis.
 * @param {number} axis 0: x; 1: y; 2: z
 * @param {number} degrees
 */
export function axisRotation(axis, degrees) {
  /** @type {Vec3} */
  const angles = [0, 0, 0];
  angles[axis] = degrees;
  return fromDegrees(angles);
}

/** @typedef {{ axis: number, sign: number }} AxisDirection a direction: the index of an axis, and 1 or -1 along it */

/**
 * Returns which of the x and y axes of a frame, and in which direction, is closest to the right on the screen
 * (`across`) and to the direction away from the camera (`ahead`).
 * @param {Quat} frame the rotation of the frame in the world
 * @param {Vec3} right the direction to the right on the screen
 * @param {Vec3} away a direction that is up on the screen or away from the camera
 * @returns {{ across: AxisDirection, ahead: AxisDirection }}
 */
export function screenAxes(frame, right, away) {
  const [x, y] = [rotate(frame, [1, 0, 0]), rotate(frame, [0, 1, 0])];
  const across = Math.abs(dot(x, right)) >= Math.abs(dot(y, right)) ? 0 : 1;
  const sign = (/** @type {Vec3} */ axis, /** @type {Vec3} */ direction) => (dot(axis, direction) < 0 ? -1 : 1);
  return {
    across: { axis: across, sign: sign(across ? y : x, right) },
    ahead: { axis: 1 - across, sign: sign(across ? x : y, away) },
  };
}
