// @ts-check
// The force with which the pointer pulls a body: a critically damped spring with a bound. This module does not need a
// page.

import { cross, dot, minus } from "./geometry.js";

/** @import { Vec3 } from "tatu/geometry" */

/** Initial natural frequency, rad/s. */
const RATE = 3;
/** Initial bound of the force per mass, N/kg: too little to tip over a robot whose wheels brake. */
export const LEAST = 3.5;
/** Growth of the bound while the body rests, N/kg per s, and its maximum, N/kg, which is enough to lift the body. */
const GROWTH = 6;
export const MOST = 15;
/** A body counts as resting below this speed, m/s, if its distance from the pointer is greater than this, m. */
const [RESTS, AWAY] = [0.05, 0.02];

/**
 * Returns the force of the spring, N. Its stiffness grows with the bound; it is always critically damped.
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
 * Returns the bound after some time, which grows while the body rests away from the pointer.
 * @param {number} bound N/kg
 * @param {Vec3} way from the body to the pointer, m
 * @param {Vec3} velocity m/s
 * @param {number} passed s
 */
export function grown(bound, way, velocity, passed) {
  const isHeld = Math.hypot(...way) > AWAY && Math.hypot(...velocity) < RESTS;
  return isHeld ? Math.min(MOST, bound + GROWTH * passed) : bound;
}

/** Tilt from which an upright body is pulled less, and from which it is not pulled at all, degrees. */
const [LEANS, TIPS] = [2, 6];

/**
 * Returns the factor of the force for a tilted body, which keeps upright bodies from falling over.
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
 * Returns the torque of a force that acts at the height of the centre of mass: it only turns the body about the
 vertical * axis, and cannot tip it over.
 * @param {Vec3} arm from the centre of mass to the point, m
 * @param {Vec3} force N
 * @returns {Vec3}
 */
export function turning([x, y], [fx, fy]) {
  return [0, 0, x * fy - y * fx];
}
