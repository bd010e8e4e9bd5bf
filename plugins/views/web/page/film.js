// Plays a recording: any time of it can be seen.

import { say, tell } from "tatu/net";
import "tatu/store";
import "tatu/tree";
import "tatu/output";
import "tatu/view";
import "tatu/sensing";
import "tatu/volumes";
import "tatu/drawings";
import { clear } from "tatu/output";

const get = (id) => document.getElementById(id);
/** Numbers of an entry of a frame, by its kind. */
const NUMBERS = { 3: 7, 4: 1, 5: 4 };
/** How each thing moved: times and numbers by the key of its entries. */
const tracks = new Map();
/** Messages with their times: scenes, events, drawings; readings by sensor. */
const scenes = [];
const events = [];
const drawings = [];
const readings = new Map();
let end = 0;

async function unpack() {
  const packed = Uint8Array.from(atob(get("recording").textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new DataView(await new Response(stream).arrayBuffer());
}

function frame(view, from, time) {
  const count = view.getUint32(from + 16, true);
  let at = from + 20;
  for (let i = 0; i < count; i++) {
    const key = view.getUint32(at, true);
    const n = NUMBERS[key >>> 24];
    if (!tracks.has(key)) tracks.set(key, { times: [], values: [] });
    const track = tracks.get(key);
    track.times.push(time);
    track.values.push(new Float64Array(view.buffer.slice(at + 4, at + 4 + 8 * n)));
    at += 4 + 8 * n;
  }
}

function text(message, time) {
  if (message.scene) scenes.push({ time, message });
  else if (message.event) events.push({ time, message });
  else if (message.drawings) drawings.push({ time, message });
  else if (message.readings) {
    for (const [id, reading] of Object.entries(message.readings)) {
      if (!readings.has(id)) readings.set(id, []);
      readings.get(id).push({ time, reading });
    }
  } else say(message);
}

function read(view) {
  for (let at = 0; at + 13 <= view.byteLength;) {
    const length = view.getUint32(at, true);
    const time = view.getFloat64(at + 4, true);
    const from = at + 13;
    at = from + length;
    end = Math.max(end, time);
    if (view.getUint8(at - length - 1) === 0) text(JSON.parse(new TextDecoder().decode(new Uint8Array(view.buffer, from, length))), time);
    else if (view.getUint8(from) === 1) frame(view, from, time);
    else tell("mesh", new DataView(view.buffer.slice(from, at)));
  }
}

/** The place of the last of sorted times that is not after `t`; -1: none. */
function last(times, t, time = (x) => x) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (time(times[middle]) <= t) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

const ofTime = (x) => x.time;
const HAIR = 1e-9;
let now = 0;
let shown = { scene: -1, drawing: -1, events: 0 };

/** Shows a time. */
function seek(time) {
  const t = time + HAIR;
  const scene = Math.max(0, last(scenes, t, ofTime));
  if (scene !== shown.scene) say(scenes[scene].message);
  const poses = [...tracks].map(([key, track]) => [key, track.values[last(track.times, t)]]).filter((x) => x[1]);
  const view = new DataView(new ArrayBuffer(20 + poses.reduce((n, [, v]) => n + 4 + 8 * v.length, 0)));
  view.setFloat64(8, time, true);
  view.setUint32(16, poses.length, true);
  let at = 20;
  for (const [key, values] of poses) {
    view.setUint32(at, key, true);
    values.forEach((x, i) => view.setFloat64(at + 4 + 8 * i, x, true));
    at += 4 + 8 * values.length;
  }
  tell("frame", view);
  const seen = {};
  for (const [id, all] of readings) {
    const i = last(all, t, ofTime);
    seen[id] = i < 0 ? { detected: false, distance: [], angle: [] } : all[i].reading;
  }
  say({ readings: seen });
  const drawing = last(drawings, t, ofTime);
  if (drawing !== shown.drawing) say(drawings[drawing]?.message ?? { drawings: [] });
  const n = last(events, t, ofTime) + 1;
  if (n < shown.events) clear();
  for (const e of events.slice(n < shown.events ? 0 : shown.events, n)) say(e.message);
  shown = { scene, drawing, events: n };
  now = time;
  get("slider").value = time;
  get("time").textContent = `${time.toFixed(2)} of ${end.toFixed(2)} s`;
}

let playing = null;
function play(on) {
  if (on && now >= end) seek(0);
  playing = on ? { clock: performance.now(), from: now } : null;
  get("play").textContent = on ? "\u275A\u275A" : "\u25B6";
  get("play").setAttribute("aria-label", on ? "Pause" : "Play");
  if (on) requestAnimationFrame(go);
}
function go(clock) {
  if (!playing) return;
  const passed = (Math.max(0, clock - playing.clock) / 1000) * Number(get("rate").value);
  seek(Math.min(end, playing.from + passed));
  if (now >= end) play(false);
  else requestAnimationFrame(go);
}

get("play").onclick = () => play(!playing);
get("rate").onchange = () => { if (playing) play(true); };
get("slider").oninput = () => {
  const going = playing !== null;
  if (going) play(false);
  seek(Number(get("slider").value));
};
document.addEventListener("keydown", (e) => {
  if (e.key !== " " || e.target.closest("button, input, select")) return;
  play(!playing);
  e.preventDefault();
});

read(await unpack());
get("slider").max = end;
seek(0);
// For tests and for links: film.html#12.5 begins there.
const begin = Number(location.hash.slice(1));
if (begin > 0) seek(Math.min(begin, end));
