// @ts-check
// Formats and rounds numbers. This module does not access the DOM, so it can be tested without a browser.

/**
 * Formats a number: an integer with all its digits, any other number with up to six significant digits.
 * @param {unknown} x a number, or the JSON representation of a non-finite number
 * @param {number} [factor]
 */
export function formatNumber(x, factor = 1) {
  if (typeof x === "object" && x !== null && "number" in x) return String(x.number).replace("inf", "\u221e");
  if (typeof x !== "number") return "";
  const y = x * factor;
  return Number.isInteger(y) ? String(y + 0) : String(+y.toPrecision(6) + 0);
}

/**
 * Formats a number with at most three decimals, or with three significant digits if it is smaller than 0.1.
 * @param {unknown} x a number, or the JSON representation of a non-finite number
 * @param {number} [factor]
 */
export function formatShort(x, factor = 1) {
  if (typeof x !== "number") return formatNumber(x, factor);
  const y = x * factor;
  return formatNumber(Math.abs(y) < 0.1 ? Number(y.toPrecision(3)) : Number(y.toFixed(3)));
}

/**
 * Rounds a number to a multiple of a step; a step of 0 leaves it unchanged.
 * @param {number} x
 * @param {number} step
 */
export function roundToStep(x, step) {
  if (!(step > 0)) return x;
  const n = Math.round(x / step) * step;
  // Removes rounding noise of the multiplication: 3 * 0.1 is 0.30000000000000004.
  return Number(n.toPrecision(12)) + 0;
}
