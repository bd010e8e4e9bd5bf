// @ts-check
// Curves as a table for spreadsheets, and files that the browser saves. Nothing of the first needs a page.

/** @import { Curve } from "tatu/plot" */

/** @param {string} text */
function cell(text) {
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/**
 * Curves as comma-separated values: a row for each time that any of them has, empty where a curve has no number.
 * @param {Curve[]} curves
 * @param {string} first the heading of the first column
 */
export function csv(curves, first) {
  const columns = curves.map(({ times, values }) => new Map(times.map((t, i) => [t, values[i]])));
  const times = [...new Set(curves.flatMap((c) => c.times))].filter((t) => t !== null).sort((a, b) => a - b);
  const head = [first, ...curves.map(({ name, unit }) => (unit ? `${name} (${unit})` : name))].map(cell).join(",");
  const rows = times.map((t) => [t, ...columns.map((c) => c.get(t) ?? "")].join(","));
  return `${[head, ...rows].join("\n")}\n`;
}

/**
 * X-Y curves as comma-separated values: two columns for each.
 * @param {Curve[]} curves
 * @param {string} along the heading of what goes along
 */
export function csvOfPairs(curves, along) {
  const head = curves.flatMap(({ name, unit }) => [along, unit ? `${name} (${unit})` : name]).map(cell).join(",");
  const most = Math.max(0, ...curves.map((c) => c.times.length));
  const rows = Array.from({ length: most }, (_, i) => curves.flatMap((c) => [c.times[i] ?? "", c.values[i] ?? ""]).join(","));
  return `${[head, ...rows].join("\n")}\n`;
}

/**
 * Lets the browser save a file.
 * @param {Blob} blob
 * @param {string} name
 */
export function download(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
