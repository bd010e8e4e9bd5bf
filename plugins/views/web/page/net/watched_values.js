// @ts-check
// Requests values of properties and readings in each step, and stores their history since the start of the run.

import { on, send } from "tatu/net/connection";

/**
 * The history of a value since the start of the run: simulation times, s, and the elements of the value at each of
 * them. `users` is the number of calls of `watchValue` without a call of `unwatch`.
 * @typedef {{ object: number, key: string, users: number, times: number[], numbers: (number | null)[][] }} Series
 */

/** Maximum number of stored samples per value. */
const MAX_SAMPLES = 20_000;
/** The watched values, by object and key. @type {Map<string, Series>} */
const watched = new Map();
/** Number of the last request, and the requested values in the order of the request. */
let lastRequest = { number: 0, series: /** @type {Series[]} */ ([]) };
let isScheduled = false;

/** Schedules a request for all watched values. Changes within the same task result in a single request. */
function request() {
  if (isScheduled) return;
  isScheduled = true;
  queueMicrotask(() => {
    isScheduled = false;
    lastRequest = { number: lastRequest.number + 1, series: [...watched.values()] };
    send({ type: "watch", of: lastRequest.number, values: lastRequest.series.map(({ object, key }) => ({ object, key })) });
  });
}

/**
 * Starts to watch a value. `unwatch` must be called when the value is no longer required.
 * @param {number} object
 * @param {string} key key of a property, or name of a field of readings
 * @returns {Series}
 */
export function watchValue(object, key) {
  const name = `${object} ${key}`;
  const existing = watched.get(name);
  if (existing) {
    existing.users++;
    return existing;
  }
  const series = { object, key, users: 1, times: [], numbers: [] };
  watched.set(name, series);
  request();
  return series;
}

/** Stops watching a value, unless it is still used elsewhere. @param {Series} series */
export function unwatch(series) {
  if (--series.users > 0) return;
  watched.delete(`${series.object} ${series.key}`);
  request();
}

on("values", ({ of, samples }) => {
  // Samples for an earlier request contain other values.
  if (of !== lastRequest.number) return;
  for (const { time, values } of samples) {
    lastRequest.series.forEach((series, i) => {
      series.times.push(time);
      series.numbers.push(values[i] ?? []);
      if (series.times.length <= MAX_SAMPLES) return;
      series.times.splice(0, MAX_SAMPLES / 10);
      series.numbers.splice(0, MAX_SAMPLES / 10);
    });
  }
});
on("event", ({ name }) => {
  if (name !== "started") return;
  for (const series of watched.values()) series.times.length = series.numbers.length = 0;
});
on("hello", () => { if (watched.size) request(); });
