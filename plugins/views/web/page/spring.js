// @ts-check
// The force with which a hand pulls a body: a critically damped spring with a bound. Nothing here needs a page.

import { dot, minus } from "./geometry.js";

/** @import { Vec3 } from "tatu/geometry" */

/** Natural frequency, rad/s: slow enough for what is seen 0.1 s late. */
const RATE = 3;
/** The greatest force for each kg at the beginning, N/kg: too little to tip a robot whose wheels brake. */
export const LEAST = 3.5;
/** How fast this bound grows while the body does not move, N/kg for each s, and up to where: enough to lift it. */
const GROWTH = 6;
export const MOST = 15;
/** Below this speed a body does not move, m/s. */
const RESTS = 0.05;

/**
 * The force of the spring, N.
 * @param {Vec3} way from the body to the pointer, m
 * @param {Vec3} velocity m/s
 * @param {number} mass kg
 * @param {number} bound N/kg
 * @returns {Vec3}
 */
export function pull(way, velocity, mass, bound) {
  /** @type {Vec3} */
  const [x, y, z] = minus([RATE * RATE * way[0], RATE * RATE * way[1], RATE * RATE * way[2]], [2 * RATE * velocity[0], 2 * RATE * velocity[1], 2 * RATE * velocity[2]]);
  const size = Math.hypot(x, y, z);
  const k = mass * (size > bound ? bound / size : 1);
  return [k * x, k * y, k * z];
}

/**
 * The bound after some time: what rests under all that it allows gets more.
 * @param {number} bound N/kg
 * @param {Vec3} force N
 * @param {Vec3} velocity m/s
 * @param {number} mass kg
 * @param {number} passed s
 */
export function grown(bound, force, velocity, mass, passed) {
  const isHeld = Math.hypot(...force) >= 0.99 * bound * mass && dot(velocity, velocity) < RESTS * RESTS;
  return isHeld ? Math.min(MOST, bound + GROWTH * passed) : bound;
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
