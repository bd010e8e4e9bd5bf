// @ts-check
// Properties and readings that are watched in each step, with their history since the start of the run.

import { on, send } from "tatu/net";

/**
 * The history of a value since the start: times, and the elements of the value at each of them.
 * @typedef {{ object: number, key: string, users: number, times: number[], numbers: (number | null)[][] }} Series
 */

/** Maximum number of stored samples per value. */
const MOST = 20_000;
/** @type {Map<string, Series>} */
const all = new Map();
/** Number of the last request, and the requested values in their order. */
let asked = { of: 0, series: /** @type {Series[]} */ ([]) };
let due = false;

/** Requests all watched values, once for all changes within the same task. */
function ask() {
  if (due) return;
  due = true;
  queueMicrotask(() => {
    due = false;
    asked = { of: asked.of + 1, series: [...all.values()] };
    send({ type: "watch", of: asked.of, values: asked.series.map(({ object, key }) => ({ object, key })) });
  });
}

/**
 * Watches a value.
 * @param {number} object
 * @param {string} key of a property, or the name of a field of its readings
 * @returns {Series}
 */
export function watchValue(object, key) {
  const name = `${object} ${key}`;
  const known = all.get(name);
  if (known) {
    known.users++;
    return known;
  }
  const series = { object, key, users: 1, times: [], numbers: [] };
  all.set(name, series);
  ask();
  return series;
}

/** @param {Series} series */
export function unwatch(series) {
  if (--series.users > 0) return;
  all.delete(`${series.object} ${series.key}`);
  ask();
}

on("values", ({ of, samples }) => {
  // Samples for an earlier request have a different order of values.
  if (of !== asked.of) return;
  for (const { time, values } of samples) {
    asked.series.forEach((series, i) => {
      series.times.push(time);
      series.numbers.push(values[i] ?? []);
      if (series.times.length <= MOST) return;
      series.times.splice(0, MOST / 10);
      series.numbers.splice(0, MOST / 10);
    });
  }
});
on("event", ({ name }) => {
  if (name !== "started") return;
  for (const series of all.values()) series.times.length = series.numbers.length = 0;
});
on("hello", () => { if (all.size) ask(); });
