// @ts-check
// The grid and the angle to which objects snap while they are placed, moved and rotated.

import { get } from "tatu/lib/dom";
import { roundToStep } from "tatu/lib/numbers";

const grid = get("snap-length", HTMLSelectElement);
const angles = get("snap-angle", HTMLSelectElement);
/** @type {(() => void)[]} */
const watchers = [];

for (const field of [grid, angles]) {
  const key = `tatu ${field.id}`;
  const stored = localStorage.getItem(key);
  if (stored !== null && [...field.options].some((o) => o.value === stored)) field.value = stored;
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
  return (Number(angles.value) * Math.PI) / 180;
}

/**
 * Rounds a coordinate to the grid.
 * @param {number} x m
 */
export function snapLength(x) {
  return roundToStep(x, lengthStep());
}

/**
 * Rounds an angle to a multiple of the step.
 * @param {number} a rad
 */
export function snapAngle(a) {
  return roundToStep(a, angleStep());
}

/**
 * Calls `f` when the user chooses another grid or angle.
 * @param {() => void} f
 */
export function watchSnap(f) {
  watchers.push(f);
}
