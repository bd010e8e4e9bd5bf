// @ts-check
// Calculates with poses. This module does not access the DOM, so it can be tested without a browser.

import { conjugate, multiply, rotate } from "./rotations.js";
import { minus, plus } from "./vectors.js";

/** @import { Quat } from "tatu/lib/rotations" */
/** @import { Vec3 } from "tatu/lib/vectors" */
/** @typedef {[number, number, number, number, number, number, number]} Pose position, then quaternion x, y, z, w */

/** The identity pose. @type {Pose} */
export const IDENTITY = [0, 0, 0, 0, 0, 0, 1];

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
  if (frame === "world") return IDENTITY;
  return frame === "own" ? world : compose(world, inverse(local));
}

/**
 * Returns the motion in the world frame for a translation along the axes of a frame.
 * @param {Pose} frame
 * @param {Vec3} by displacement in `frame`
 * @returns {Pose}
 */
export function translationAlong(frame, by) {
  return [...rotate(rotationOf(frame), by), 0, 0, 0, 1];
}

/**
 * Returns the motion in the world frame for a rotation about a point.
 * @param {Pose} frame
 * @param {Quat} by rotation in `frame`
 * @param {Vec3} about the point in the world frame
 * @returns {Pose}
 */
export function rotationAbout(frame, by, about) {
  const q = multiply(multiply(rotationOf(frame), by), conjugate(rotationOf(frame)));
  return [...minus(about, rotate(q, about)), ...q];
}

/**
 * Returns the pose of an object in the frame of its parent after a motion in the world frame.
 * @param {Pose} motion
 * @param {{ world: Pose, local: Pose }} from the poses before the motion, in the world and in the frame of the parent
 * @returns {Pose}
 */
export function movedPose(motion, { world, local }) {
  const [x, y, z, ...q] = compose(compose(local, inverse(world)), compose(motion, world));
  const length = Math.hypot(...q) || 1;
  // Rounding removes floating-point noise, so that an object placed at 0.6 is exactly at 0.6.
  const one = (/** @type {number} */ a) => Math.round(a * 1e12) / 1e12 + 0;
  const [a, b, c, d] = q;
  return [one(x), one(y), one(z), one(a / length), one(b / length), one(c / length), one(d / length)];
}
