// @ts-check
// Formats curves as tables for spreadsheets. This module does not access the DOM, so it can be tested without a
// browser.

/** @import { Curve } from "tatu/lib/plot" */

/** Formats a cell, quoted if necessary. @param {string} text */
function cell(text) {
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/**
 * Formats curves as comma-separated values, with a row for each time at which any curve has a sample. Missing values
 * are empty cells.
 * @param {Curve[]} curves
 * @param {string} first the heading of the first column
 */
export function csv(curves, first) {
  const columns = curves.map(({ times, values }) => new Map(times.map((t, i) => [t, values[i]])));
  const times = [...new Set(curves.flatMap((c) => c.times))].filter((t) => t !== null).sort((a, b) => a - b);
  const header = [first, ...curves.map(({ name, unit }) => (unit ? `${name} (${unit})` : name))].map(cell).join(",");
  const rows = times.map((t) => [t, ...columns.map((c) => c.get(t) ?? "")].join(","));
  return `${[header, ...rows].join("\n")}\n`;
}

/**
 * Formats x-y curves as comma-separated values, with two columns per curve.
 * @param {Curve[]} curves
 * @param {string} along the heading of the x values
 */
export function csvOfPairs(curves, along) {
  const header = curves.flatMap(({ name, unit }) => [along, unit ? `${name} (${unit})` : name]).map(cell).join(",");
  const length = Math.max(0, ...curves.map((c) => c.times.length));
  const rows = Array.from({ length }, (_, i) => curves.flatMap((c) => [c.times[i] ?? "", c.values[i] ?? ""]).join(","));
  return `${[header, ...rows].join("\n")}\n`;
}
