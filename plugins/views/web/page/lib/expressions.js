// @ts-check
// Evaluates typed quantities such as "2*3", "45 deg" or "10 cm + 5 mm". This module does not access the DOM.

import { t } from "tatu/lib/language";
/** Units of the same dimension, each with its ratio to the first one. @type {{ [unit: string]: number }[]} */
const DIMENSIONS = [
  { m: 1, cm: 0.01, mm: 0.001, km: 1000, in: 0.0254 },
  { "\u00b0": 1, deg: 1, rad: 180 / Math.PI, turn: 360 },
  { s: 1, ms: 0.001, min: 60, h: 3600 },
  { kg: 1, g: 0.001, t: 1000 },
  { N: 1, mN: 0.001, kN: 1000 },
  { "N m": 1, Nm: 1, "mN m": 0.001, mNm: 0.001 },
  { "m/s": 1, "cm/s": 0.01, "mm/s": 0.001, "km/h": 1 / 3.6 },
  { "\u00b0/s": 1, "deg/s": 1, "rad/s": 180 / Math.PI, rpm: 6 },
  { Hz: 1, kHz: 1000 },
];
const NUMBER = /^(\d+(?:[.,]\d*)?|[.,]\d+)(?:e[+-]?\d+)?/i;
/** A unit; a slash belongs to it only if a unit of time follows. */
const UNIT = /^(?:m?N m\b|[a-z\u00b0]+(?:\/(?:s|h)\b)?)/i;
/** Maximum length of an expression, which also bounds the depth of parentheses. */
const MAX_LENGTH = 200;

/**
 * Returns the ratio of a unit to another one.
 * @param {string} unit
 * @param {string} target
 */
function ratioOf(unit, target) {
  const dimension = DIMENSIONS.find((d) => unit in d);
  const [from, to] = [dimension?.[unit], dimension?.[target]];
  if (from !== undefined && to !== undefined) return from / to;
  throw { error: target ? t`"${unit}" is not a unit of this value, which is in ${target}` : t`"${unit}" is not a unit of this value, which has none` };
}

/**
 * Evaluates an expression of numbers, the operators + - * /, parentheses and pi. Numbers and parentheses may be followed by
 * a unit; those without one are in the target unit. A comma is accepted as the decimal separator. Throws a failure if the
 * expression is invalid.
 * @param {string} text
 * @param {string} unit the target unit; "": none
 * @returns {number} in the target unit
 */
export function evaluate(text, unit) {
  let rest = text.replaceAll("\u2212", "-").replaceAll("\u00b7", "*").trim();
  const invalid = () => ({ error: unit ? t`expected a number in ${unit}, found "${text}"` : t`expected a number, found "${text}"` });
  if (!rest || rest.length > MAX_LENGTH) throw invalid();
  /** Removes a part from the beginning of the text, and returns it; null if it is not there. @param {RegExp} pattern */
  const take = (pattern) => {
    const found = rest.match(pattern)?.[0];
    if (found === undefined) return null;
    rest = rest.slice(found.length).trimStart();
    return found;
  };
  const primary = () => {
    if (take(/^\(/)) {
      const value = sum();
      if (!take(/^\)/)) throw invalid();
      return value;
    }
    if (take(/^pi\b/i)) return Math.PI;
    if (take(/^(inf\b|\u221e)/i)) return Infinity;
    const digits = take(NUMBER);
    if (digits === null) throw invalid();
    return Number(digits.replace(",", "."));
  };
  /** @returns {number} */
  const factor = () => {
    if (take(/^-/)) return -factor();
    if (take(/^\+/)) return factor();
    const value = primary();
    const suffix = take(UNIT);
    return suffix === null ? value : value * ratioOf(suffix, unit);
  };
  const product = () => {
    let value = factor();
    for (;;) {
      if (take(/^\*/)) value *= factor();
      else if (take(/^\//)) value /= factor();
      else return value;
    }
  };
  /** @returns {number} */
  const sum = () => {
    let value = product();
    for (;;) {
      if (take(/^\+/)) value += product();
      else if (take(/^-/)) value -= product();
      else return value;
    }
  };
  const value = sum();
  if (rest || Number.isNaN(value)) throw invalid();
  return value;
}
