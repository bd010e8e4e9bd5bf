// @ts-check
// Calculates with vectors of three components. This module does not access the DOM, so it can be tested without a
// browser.

/** @typedef {[number, number, number]} Vec3 */

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
