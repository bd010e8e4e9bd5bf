// @ts-check
// The grid and the angle to which objects snap while they are placed, moved and rotated.

import { get } from "tatu/lib/dom";
import { snap } from "tatu/lib/numbers";

const grid = get("snap-length", HTMLSelectElement);
const turns = get("snap-angle", HTMLSelectElement);
/** @type {(() => void)[]} */
const watchers = [];

for (const field of [grid, turns]) {
  const key = `tatu ${field.id}`;
  const kept = localStorage.getItem(key);
  if (kept !== null && [...field.options].some((o) => o.value === kept)) field.value = kept;
  field.addEventListener("change", () => {
    localStorage.setItem(key, field.value);
    for (const f of watchers) f();
  });
}

/** Returns the spacing of the grid, m; 0 if positions do not snap. */
export function lengthStep() {
  return Number(grid.value);
}

/** Returns the step of angles, rad; 0 if angles do not snap. */
export function angleStep() {
  return (Number(turns.value) * Math.PI) / 180;
}

/**
 * Rounds a coordinate to the grid.
 * @param {number} x m
 */
export function snapLength(x) {
  return snap(x, lengthStep());
}

/**
 * Rounds an angle to a multiple of the step.
 * @param {number} a rad
 */
export function snapAngle(a) {
  return snap(a, angleStep());
}

/**
 * Calls `f` when the user chooses another grid or angle.
 * @param {() => void} f
 */
export function watchSnap(f) {
  watchers.push(f);
}
