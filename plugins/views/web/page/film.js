// @ts-check
// Plays the recording of a film.

import { get } from "tatu/dom";
import { say, tell } from "tatu/film_net";
import { icon } from "tatu/icons";
import { entryLength } from "tatu/parse";
import "tatu/tree";
import "tatu/output";
import "tatu/view";
import "tatu/looking";
import "tatu/sensing";
import "tatu/volumes";
import "tatu/drawings";
import { clear } from "tatu/output";
import { select } from "tatu/store";
import { hitAt, renderer } from "tatu/view";

/** @import { Reading, SceneObject, ToPage } from "tatu/protocol" */

/**
 * The motion of objects: the recorded times and values of each frame entry, by the key of the entry.
 * @type {Map<number, { times: number[], values: Float64Array[] }>}
 */
const tracks = new Map();
/** @typedef {{ time: number, message: ToPage }} Told */
/** The complete scenes. @type {Told[]} */
const scenes = [];
/** Objects that have changed in other ways than by moving. @type {{ time: number, objects: SceneObject[] }[]} */
const changes = [];
/** @type {Told[]} */
const events = [];
/** @type {Told[]} */
const drawings = [];
/** @type {Map<number, { time: number, reading: Reading | null }[]>} */
const readings = new Map();
const slider = get("slider", HTMLInputElement);
const rate = get("rate", HTMLSelectElement);
let end = 0;

// A click selects the object under the pointer; a drag rotates the camera instead.
let down = { x: 0, y: 0 };
renderer.domElement.addEventListener("pointerdown", (e) => { down = { x: e.clientX, y: e.clientY }; });
renderer.domElement.addEventListener("pointerup", (e) => {
  if (Math.hypot(e.clientX - down.x, e.clientY - down.y) <= 4) select(hitAt(e)?.id ?? 0);
});

/** Returns a promise of the decompressed recording. */
async function unpack() {
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
function frame(view, from, time) {
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
function text(message, time) {
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
  } else say(message);
}

/** Reads all records of the recording. @param {DataView<ArrayBuffer>} view */
function read(view) {
  for (let at = 0; at + 13 <= view.byteLength;) {
    const length = view.getUint32(at, true);
    const time = view.getFloat64(at + 4, true);
    const from = at + 13;
    at = from + length;
    end = Math.max(end, time);
    if (view.getUint8(at - length - 1) === 0) text(JSON.parse(new TextDecoder().decode(new Uint8Array(view.buffer, from, length))), time);
    else if (view.getUint8(from) === 1) frame(view, from, time);
    else tell(view.getUint8(from) === 4 ? "texture" : "mesh", new DataView(view.buffer.slice(from, at)));
  }
}

/**
 * Returns the index of the last of `n` sorted times that is not after `t`, or -1 if all of them are after `t`.
 * @param {number} n
 * @param {number} t
 * @param {(i: number) => number | undefined} time returns the time with an index
 */
function last(n, t, time) {
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
const lastOf = (all, t) => last(all.length, t, (i) => all[i]?.time);
/** Tolerance for rounding errors in times, s. */
const HAIR = 1e-9;
let now = 0;
let shown = { scene: -1, change: -1, drawing: -1, events: 0 };

/**
 * Shows the recorded state at a time.
 * @param {number} time
 */
function seek(time) {
  const t = time + HAIR;
  const scene = Math.max(0, lastOf(scenes, t));
  const whole = scenes[scene];
  const change = lastOf(changes, t);
  const anew = scene !== shown.scene || change < shown.change;
  if (whole && anew) say(whole.message);
  if (whole && (anew || change > shown.change)) {
    // The scene includes all changes before its own time.
    const since = changes.slice(anew ? 0 : shown.change + 1, change + 1).filter((c) => c.time >= whole.time);
    const newest = new Map(since.flatMap((c) => c.objects).map((o) => [o.id, o]));
    if (newest.size) say({ type: "objects", objects: [...newest.values()] });
  }
  const poses = [...tracks].flatMap(([key, { times, values }]) => {
    const numbers = values[last(times.length, t, (i) => times[i])];
    return numbers ? [{ key, numbers }] : [];
  });
  const view = new DataView(new ArrayBuffer(20 + poses.reduce((n, { numbers }) => n + 4 + 8 * numbers.length, 0)));
  view.setFloat64(8, time, true);
  view.setUint32(16, poses.length, true);
  let at = 20;
  for (const { key, numbers } of poses) {
    view.setUint32(at, key, true);
    numbers.forEach((x, i) => view.setFloat64(at + 4 + 8 * i, x, true));
    at += 4 + 8 * numbers.length;
  }
  tell("frame", view);
  /** @type {{ [id: number]: Reading | null }} */
  const seen = {};
  for (const [id, all] of readings) seen[id] = all[lastOf(all, t)]?.reading ?? null;
  say({ type: "readings", readings: seen });
  const drawing = lastOf(drawings, t);
  if (drawing !== shown.drawing) say(drawings[drawing]?.message ?? { type: "drawings", drawings: [] });
  const n = lastOf(events, t) + 1;
  if (n < shown.events) clear();
  for (const e of events.slice(n < shown.events ? 0 : shown.events, n)) say(e.message);
  shown = { scene, change, drawing, events: n };
  now = time;
  slider.value = String(time);
  get("time").textContent = `${time.toFixed(2)} of ${end.toFixed(2)} s`;
}

/** @type {{ clock: number, from: number } | null} */
let playing = null;
/** @param {boolean} on */
function play(on) {
  if (on && now >= end) seek(0);
  playing = on ? { clock: performance.now(), from: now } : null;
  get("play").replaceChildren(icon(on ? "pause" : "play"));
  get("play").setAttribute("aria-label", on ? "Pause" : "Play");
  if (on) requestAnimationFrame(go);
}
/** @param {number} clock */
function go(clock) {
  if (!playing) return;
  const passed = (Math.max(0, clock - playing.clock) / 1000) * Number(rate.value);
  seek(Math.min(end, playing.from + passed));
  if (now >= end) play(false);
  else requestAnimationFrame(go);
}

get("play").onclick = () => play(!playing);
rate.onchange = () => { if (playing) play(true); };
slider.oninput = () => {
  const going = playing !== null;
  if (going) play(false);
  seek(Number(slider.value));
};
document.addEventListener("keydown", (e) => {
  if (e.key !== " " || (e.target instanceof Element && e.target.closest("button, input, select"))) return;
  play(!playing);
  e.preventDefault();
});

read(await unpack());
slider.max = String(end);
seek(0);
// The hash of the address sets the initial time: film.html#12.5 starts at 12.5 s.
const begin = Number(location.hash.slice(1));
if (begin > 0) seek(Math.min(begin, end));
