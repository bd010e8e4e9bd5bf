// @ts-check
// The recording of a film: messages with their times, ordered by kind.

import { get } from "tatu/lib/dom";
import { entryLength } from "tatu/net/binary_messages";
import { deliver, deliverMessage } from "tatu/film/connection";

/** @import { Reading, SceneObject, ToPage } from "tatu/protocol" */

/**
 * The motion of objects: the recorded times and values of each frame entry, by the key of the entry.
 * @type {Map<number, { times: number[], values: Float64Array[] }>}
 */
export const tracks = new Map();
/** @typedef {{ time: number, message: ToPage }} TimedMessage */
/** The complete scenes. @type {TimedMessage[]} */
export const scenes = [];
/** Objects that have changed in other ways than by moving. @type {{ time: number, objects: SceneObject[] }[]} */
export const changes = [];
/** @type {TimedMessage[]} */
export const events = [];
/** @type {TimedMessage[]} */
export const drawings = [];
/** @type {Map<number, { time: number, reading: Reading | null }[]>} */
export const readings = new Map();
/** Time of the last record, s. */
export let end = 0;

/** Returns a promise of the decompressed recording. */
export async function unpackRecording() {
  const packed = Uint8Array.from(atob(get("recording").textContent ?? ""), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new DataView(await new Response(stream).arrayBuffer());
}

/**
 * Stores the entries of a frame.
 * @param {DataView} view
 * @param {number} from offset of the frame, bytes
 * @param {number} time s
 */
function storeFrame(view, from, time) {
  const count = view.getUint32(from + 16, true);
  let at = from + 20;
  for (let i = 0; i < count; i++) {
    const key = view.getUint32(at, true);
    const n = entryLength(key >>> 24) / 8;
    const track = tracks.get(key) ?? { times: [], values: [] };
    tracks.set(key, track);
    track.times.push(time);
    track.values.push(new Float64Array(view.buffer.slice(at + 4, at + 4 + 8 * n)));
    at += 4 + 8 * n;
  }
}

/**
 * Stores a text message, or delivers it if it does not depend on time.
 * @param {ToPage} message
 * @param {number} time s
 */
function storeMessage(message, time) {
  if (message.type === "scene") scenes.push({ time, message });
  else if (message.type === "objects") changes.push({ time, objects: message.objects });
  else if (message.type === "event") events.push({ time, message });
  else if (message.type === "drawings") drawings.push({ time, message });
  else if (message.type === "readings") {
    for (const [key, reading] of Object.entries(message.readings)) {
      const all = readings.get(Number(key)) ?? [];
      readings.set(Number(key), all);
      all.push({ time, reading: reading ?? null });
    }
  } else deliverMessage(message);
}

/** Reads all records of the recording. @param {DataView<ArrayBuffer>} view */
export function readRecording(view) {
  for (let at = 0; at + 13 <= view.byteLength;) {
    const length = view.getUint32(at, true);
    const time = view.getFloat64(at + 4, true);
    const from = at + 13;
    at = from + length;
    end = Math.max(end, time);
    if (view.getUint8(at - length - 1) === 0) storeMessage(JSON.parse(new TextDecoder().decode(new Uint8Array(view.buffer, from, length))), time);
    else if (view.getUint8(from) === 1) storeFrame(view, from, time);
    else deliver(view.getUint8(from) === 4 ? "texture" : "mesh", new DataView(view.buffer.slice(from, at)));
  }
}

/**
 * Returns the index of the last of `n` sorted times that is not after `t`, or -1 if all of them are after `t`.
 * @param {number} n
 * @param {number} t
 * @param {(i: number) => number | undefined} time returns the time with an index
 */
export function lastIndex(n, t, time) {
  let [low, high] = [0, n];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((time(middle) ?? Infinity) <= t) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/**
 * Returns the index of the last entry of an array that is not after `t`, or -1 if all of them are after `t`.
 * @param {{ time: number }[]} all
 * @param {number} t
 */
export const lastEntry = (all, t) => lastIndex(all.length, t, (i) => all[i]?.time);
