// @ts-check
// Computes the force with which the pointer pulls a body: that of a critically damped spring, limited by a bound. This
// module does not access the DOM, so it can be tested without a browser.

import { cross, dot, minus } from "../lib/vectors.js";

/** @import { Vec3 } from "tatu/lib/vectors" */

/** Natural frequency of the spring for the initial bound, rad/s. */
const RATE = 3;
/** Initial bound of the force per mass, N/kg. It is too small to tip over a robot with braking wheels. */
export const INITIAL_BOUND = 3.5;
/** Growth rate of the bound while the body rests, N/kg per s. */
const GROWTH = 6;
/** Maximum of the bound, N/kg, which is sufficient to lift the body. */
export const MAX_BOUND = 15;
/**
 * A body rests if its speed is below `REST_SPEED`, m/s, and its distance from the pointer is above `REST_DISTANCE`, m.
 */
const [REST_SPEED, REST_DISTANCE] = [0.05, 0.02];

/**
 * Returns the force of the spring, N. Its stiffness is proportional to the bound; it is always critically damped.
 * @param {Vec3} displacement from the body to the pointer, m
 * @param {Vec3} velocity m/s
 * @param {number} mass kg
 * @param {number} bound N/kg
 * @returns {Vec3}
 */
export function springForce(displacement, velocity, mass, bound) {
  const stiffness = (RATE * RATE * bound) / INITIAL_BOUND;
  const damping = 2 * Math.sqrt(stiffness);
  const [x, y, z] = minus(scaled(displacement, stiffness), scaled(velocity, damping));
  const size = Math.hypot(x, y, z);
  return scaled([x, y, z], mass * (size > bound ? bound / size : 1));
}

/**
 * Returns a vector multiplied by a factor.
 * @param {Vec3} v
 * @param {number} k
 * @returns {Vec3}
 */
function scaled([x, y, z], k) {
  return [k * x, k * y, k * z];
}

/**
 * Returns the bound after some time. It grows while the body rests away from the pointer.
 * @param {number} bound N/kg
 * @param {Vec3} displacement from the body to the pointer, m
 * @param {Vec3} velocity m/s
 * @param {number} elapsed s
 */
export function nextBound(bound, displacement, velocity, elapsed) {
  const isResting = Math.hypot(...displacement) > REST_DISTANCE && Math.hypot(...velocity) < REST_SPEED;
  return isResting ? Math.min(MAX_BOUND, bound + GROWTH * elapsed) : bound;
}

/** Tilts, degrees: above `LEAN_ANGLE`, a body is pulled with less force, and above `TIP_ANGLE`, it is not pulled. */
const [LEAN_ANGLE, TIP_ANGLE] = [2, 6];

/**
 * Returns the factor by which the force on a tilted body is reduced, so that it does not tip over.
 * @param {number} tilt degrees
 */
export function tiltFactor(tilt) {
  return Math.min(1, Math.max(0, (TIP_ANGLE - tilt) / (TIP_ANGLE - LEAN_ANGLE)));
}

/**
 * Returns the angle between two directions, degrees.
 * @param {Vec3} a
 * @param {Vec3} b
 */
export function angleBetween(a, b) {
  return (Math.atan2(Math.hypot(...cross(a, b)), dot(a, b)) * 180) / Math.PI;
}

/**
 * Returns the torque of a force, N m, as if the force acted at the height of the centre of mass. Horizontal forces then
 * rotate the body about the vertical axis only, and cannot tip it over.
 * @param {Vec3} arm from the centre of mass to the point, m
 * @param {Vec3} force N
 * @returns {Vec3}
 */
export function uprightTorque([x, y], [fx, fy]) {
  return [0, 0, x * fy - y * fx];
}
