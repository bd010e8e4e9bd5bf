// @ts-check
// Formats, parses and rounds numbers. This module does not access the DOM, so it can be tested without a browser.

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
 * Parses a typed number, and divides it by a factor. Returns NaN if it is invalid. A single comma is accepted as the
 * decimal separator.
 * @param {string} text
 * @param {number} [factor]
 * @returns {number}
 */
export function parseNumber(text, factor = 1) {
  const t = text.trim().replace("\u2212", "-");
  if (/^[+-]?(inf|\u221e)$/i.test(t)) return t.startsWith("-") ? -Infinity : Infinity;
  return t === "" ? NaN : Number(/^[^.,]*,[^.,]*$/.test(t) ? t.replace(",", ".") : t) / factor;
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
