// @ts-check
// Plays the recording of a film.

import { get } from "tatu/lib/dom";
import { icon } from "tatu/lib/icons";
import { select } from "tatu/scene/store";
import { hitAt } from "tatu/view/picking";
import { renderer } from "tatu/view/renderer";
import { clear } from "tatu/panels/output";
import { deliver, deliverMessage } from "tatu/film/connection";
import { changes, drawings, end, events, lastIndex, lastEntry, readRecording, readings, scenes, tracks, unpackRecording } from "tatu/film/recording";
import "tatu/view/camera_controls";
import "tatu/view/sensor_readings";
import "tatu/view/sensor_volumes";
import "tatu/view/drawings";
import "tatu/panels/tree";

/** @import { Reading } from "tatu/protocol" */

const slider = get("slider", HTMLInputElement);
const speedSelect = get("rate", HTMLSelectElement);

// A click selects the object under the pointer; a drag rotates the camera instead.
let press = { x: 0, y: 0 };
renderer.domElement.addEventListener("pointerdown", (e) => { press = { x: e.clientX, y: e.clientY }; });
renderer.domElement.addEventListener("pointerup", (e) => {
  if (Math.hypot(e.clientX - press.x, e.clientY - press.y) <= 4) select(hitAt(e)?.id ?? 0);
});

/** Tolerance for rounding errors in times, s. */
const TOLERANCE = 1e-9;
let now = 0;
let shown = { scene: -1, change: -1, drawing: -1, events: 0 };

/**
 * Shows the recorded state at a time.
 * @param {number} time
 */
function seek(time) {
  const t = time + TOLERANCE;
  const scene = Math.max(0, lastEntry(scenes, t));
  const sceneRecord = scenes[scene];
  const change = lastEntry(changes, t);
  const isRestart = scene !== shown.scene || change < shown.change;
  if (sceneRecord && isRestart) deliverMessage(sceneRecord.message);
  if (sceneRecord && (isRestart || change > shown.change)) {
    // The scene includes all changes before its own time.
    const newChanges = changes.slice(isRestart ? 0 : shown.change + 1, change + 1).filter((c) => c.time >= sceneRecord.time);
    const newest = new Map(newChanges.flatMap((c) => c.objects).map((o) => [o.id, o]));
    if (newest.size) deliverMessage({ type: "objects", objects: [...newest.values()] });
  }
  const poses = [...tracks].flatMap(([key, { times, values }]) => {
    const numbers = values[lastIndex(times.length, t, (i) => times[i])];
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
  deliver("frame", view);
  /** @type {{ [id: number]: Reading | null }} */
  const currentReadings = {};
  for (const [id, all] of readings) currentReadings[id] = all[lastEntry(all, t)]?.reading ?? null;
  deliverMessage({ type: "readings", readings: currentReadings });
  const drawing = lastEntry(drawings, t);
  if (drawing !== shown.drawing) deliverMessage(drawings[drawing]?.message ?? { type: "drawings", drawings: [] });
  const n = lastEntry(events, t) + 1;
  if (n < shown.events) clear();
  for (const e of events.slice(n < shown.events ? 0 : shown.events, n)) deliverMessage(e.message);
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
  if (on) requestAnimationFrame(playFrame);
}
/** @param {number} frameTime */
function playFrame(frameTime) {
  if (!playing) return;
  const elapsed = (Math.max(0, frameTime - playing.clock) / 1000) * Number(speedSelect.value);
  seek(Math.min(end, playing.from + elapsed));
  if (now >= end) play(false);
  else requestAnimationFrame(playFrame);
}

get("play").onclick = () => play(!playing);
speedSelect.onchange = () => { if (playing) play(true); };
slider.oninput = () => {
  const wasPlaying = playing !== null;
  if (wasPlaying) play(false);
  seek(Number(slider.value));
};
document.addEventListener("keydown", (e) => {
  if (e.key !== " " || (e.target instanceof Element && e.target.closest("button, input, select"))) return;
  play(!playing);
  e.preventDefault();
});

readRecording(await unpackRecording());
slider.max = String(end);
seek(0);
// The hash of the address sets the initial time: film.html#12.5 starts at 12.5 s.
const begin = Number(location.hash.slice(1));
if (begin > 0) seek(Math.min(begin, end));
