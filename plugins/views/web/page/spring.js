// @ts-check
// The force with which a hand pulls a body: a critically damped spring with a bound. Nothing here needs a page.

import { cross, dot, minus } from "./geometry.js";

/** @import { Vec3 } from "tatu/geometry" */

/** Natural frequency at the beginning, rad/s. */
const RATE = 3;
/** The greatest force for each kg at the beginning, N/kg: too little to tip a robot whose wheels brake. */
export const LEAST = 3.5;
/** How fast this bound grows while the body rests, N/kg for each s, and up to where: enough to lift it. */
const GROWTH = 6;
export const MOST = 15;
/** A body rests below this speed, m/s, if it is farther away than this, m. */
const [RESTS, AWAY] = [0.05, 0.02];

/**
 * The force of the spring, N. It is stiffer when its bound has grown, and damped critically all the same.
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
 * @param {Vec3} v
 * @param {number} k
 * @returns {Vec3}
 */
function scaled([x, y, z], k) {
  return [k * x, k * y, k * z];
}

/**
 * The bound after some time: what rests away from the pointer is pulled harder.
 * @param {number} bound N/kg
 * @param {Vec3} way from the body to the pointer, m
 * @param {Vec3} velocity m/s
 * @param {number} passed s
 */
export function grown(bound, way, velocity, passed) {
  const isHeld = Math.hypot(...way) > AWAY && Math.hypot(...velocity) < RESTS;
  return isHeld ? Math.min(MOST, bound + GROWTH * passed) : bound;
}

/** From which tilt on a body that stands is pulled less, and from which not at all, degrees. */
const [LEANS, TIPS] = [2, 6];

/**
 * Which part of its force is left for a body that has tilted, since what stands should not fall.
 * @param {number} tilt degrees
 */
export function steadied(tilt) {
  return Math.min(1, Math.max(0, (TIPS - tilt) / (TIPS - LEANS)));
}

/**
 * The angle between two directions, degrees.
 * @param {Vec3} a
 * @param {Vec3} b
 */
export function between(a, b) {
  return (Math.atan2(Math.hypot(...cross(a, b)), dot(a, b)) * 180) / Math.PI;
}

/**
 * The torque of a force that acts at the height of the centre of mass: it turns about the vertical only, and tips
 * nothing.
 * @param {Vec3} arm from the centre of mass to the point, m
 * @param {Vec3} force N
 * @returns {Vec3}
 */
export function turning([x, y], [fx, fy]) {
  return [0, 0, x * fy - y * fx];
}
