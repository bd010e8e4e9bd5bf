// @ts-check
// Computes the force with which the pointer pulls a body: that of a critically damped spring, limited by a bound. This
// module does not access the DOM, so it can be tested without a browser.

import { cross, dot, minus } from "../lib/vectors.js";

/** @import { Vec3 } from "tatu/lib/vectors" */

/** Natural frequency of the spring for the initial bound, rad/s. */
const RATE = 3;
/** Initial bound of the force per mass, N/kg. It is too small to tip over a robot with braking wheels. */
export const LEAST = 3.5;
/** Growth rate of the bound while the body rests, N/kg per s. */
const GROWTH = 6;
/** Maximum of the bound, N/kg, which is sufficient to lift the body. */
export const MOST = 15;
/** A body rests if its speed is below `RESTS`, m/s, and its distance from the pointer is above `AWAY`, m. */
const [RESTS, AWAY] = [0.05, 0.02];

/**
 * Returns the force of the spring, N. Its stiffness is proportional to the bound; it is always critically damped.
 * @param {Vec3} way from the body to the pointer, m
 * @param {Vec3} velocity m/s
 * @param {number} mass kg
 * @param {number} bound N/kg
 * @returns {Vec3}
 */
export function pull(way, velocity, mass, bound) {
  const stiffness = (RATE * RATE * bound) / LEAST;
  const damping = 2 * Math.sqrt(stiffness);
  const [x, y, z] = minus(scaled(way, stiffness), scaled(velocity, damping));
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
 * @param {Vec3} way from the body to the pointer, m
 * @param {Vec3} velocity m/s
 * @param {number} passed s
 */
export function grown(bound, way, velocity, passed) {
  const isHeld = Math.hypot(...way) > AWAY && Math.hypot(...velocity) < RESTS;
  return isHeld ? Math.min(MOST, bound + GROWTH * passed) : bound;
}

/** Tilts, degrees: above `LEANS`, a body is pulled with less force, and above `TIPS`, it is not pulled. */
const [LEANS, TIPS] = [2, 6];

/**
 * Returns the factor by which the force on a tilted body is reduced, so that it does not tip over.
 * @param {number} tilt degrees
 */
export function steadied(tilt) {
  return Math.min(1, Math.max(0, (TIPS - tilt) / (TIPS - LEANS)));
}

/**
 * Returns the angle between two directions, degrees.
 * @param {Vec3} a
 * @param {Vec3} b
 */
export function between(a, b) {
  return (Math.atan2(Math.hypot(...cross(a, b)), dot(a, b)) * 180) / Math.PI;
}

/**
 * Returns the torque of a force, N m, as if the force acted at the height of the centre of mass. Horizontal forces then
 * rotate the body about the vertical axis only, and cannot tip it over.
 * @param {Vec3} arm from the centre of mass to the point, m
 * @param {Vec3} force N
 * @returns {Vec3}
 */
export function turning([x, y], [fx, fy]) {
  return [0, 0, x * fy - y * fx];
}
