// @ts-check
// Calculates with inertia matrices. This module does not access the DOM, so it can be tested without a browser.

/** @import { Vec3 } from "tatu/lib/vectors" */

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
