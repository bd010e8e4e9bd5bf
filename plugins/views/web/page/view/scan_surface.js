// @ts-check
// Computes the surface of a scan. This module does not access the DOM, so it can be tested without a browser.

/**
 * Converts a scan to triangles between the sensor and neighbouring beams. Beams are ordered by layer and, within a
 * layer, by angle, so a new layer starts where the angle decreases. Layers are not joined.
 * @param {{ distance: (number | null)[], angle: number[], elevation?: number[], range?: number }} scan
 * @returns {{ points: number[], index: number[] }} the coordinates of the points, the sensor first, and the indices of the
 *   points of the triangles
 */
export function scanSurface({ distance, angle, elevation, range }) {
  const longest = distance.reduce((/** @type {number} */ most, d) => Math.max(most, d ?? 0), 0);
  // If the range is unlimited, beams without a hit are drawn as long as the longest one with a hit, or 10 m.
  const missLength = range ?? (longest || 10);
  const points = [0, 0, 0];
  /** @type {number[]} */
  const index = [];
  distance.forEach((d, i) => {
    const [length, a, e] = [d ?? missLength, angle[i] ?? 0, elevation?.[i] ?? 0];
    points.push(Math.sin(a) * Math.cos(e) * length, Math.sin(e) * length, Math.cos(a) * Math.cos(e) * length);
    if (i > 0 && (angle[i] ?? 0) >= (angle[i - 1] ?? 0)) index.push(0, i, i + 1);
  });
  return { points, index };
}
