// @ts-check
// The controls for play, pause, step, stop and speed, and the display of the simulation time.

import { get } from "tatu/lib/dom";
import { timeOf } from "tatu/net/binary_messages";
import { on, send } from "tatu/net/connection";

/** @import { RunAction, RunState } from "tatu/protocol" */

const SPEEDS = [0.125, 0.25, 0.5, 1, 1.5, 2, 3, 4, 6, 8, 10, 15, 20, 40];
/** @type {RunState} */
let state = "stopped";
let speed = 1;
let dt = 0.05;

/** Sends a `run` request. @param {RunAction} action */
export function act(action) {
  send({ type: "run", action });
}

get("play").onclick = () => act("start");
get("pause").onclick = () => act("pause");
get("step").onclick = () => act("step");
get("stop").onclick = () => act("stop");
document.addEventListener("keydown", (e) => {
  if (e.key === "F5") act(state === "running" ? "pause" : "start");
  else if (e.key === "F6") act("step");
  else if (e.key === "F7") act("stop");
  else return;
  e.preventDefault();
});

/** Changes to the next higher or lower speed. @param {boolean} faster */
function turn(faster) {
  const next = faster ? SPEEDS.find((s) => s > speed) : SPEEDS.findLast((s) => s < speed);
  if (next) send({ type: "speed", speed: next });
}
get("faster").onclick = () => turn(true);
get("slower").onclick = () => turn(false);

on("state", (message) => {
  ({ state, speed, dt } = message);
  get("play").classList.toggle("on", state === "running");
  get("pause").classList.toggle("on", state === "paused");
  get("stop").classList.toggle("on", state === "stopped");
  if (state === "stopped") get("time").textContent = clock(0);
  if (state !== "running") pace(null);
  get("speed").textContent = speed > 0 ? `${speed}x` : "max";
});

/**
 * Formats a time as hours:minutes:seconds with hundredths.
 * @param {number} t s
 */
function clock(t) {
  const pad = (/** @type {number} */ x) => String(x).padStart(2, "0");
  return `${pad(Math.floor(t / 3600))}:${pad(Math.floor(t / 60) % 60)}:${(t % 60).toFixed(2).padStart(5, "0")}`;
}

/**
 * Shows the length of a step, and the speed of the simulation.
 * @param {number | null} factor multiple of real time; null: not shown
 */
function pace(factor) {
  const step = `dt ${+(dt * 1000).toFixed(3)} ms`;
  get("factor").textContent = factor === null ? step : `${step} \u00B7 ${factor.toFixed(2)}x`;
}

/** @type {{ now: number, time: number } | null} */
let before = null;
on("frame", (view) => {
  // While the simulation is stopped, time 0 is shown, at which the next run starts.
  const time = state === "stopped" ? 0 : timeOf(view);
  get("time").textContent = clock(time);
  const now = performance.now() / 1000;
  if (!before || time < before.time) before = { now, time };
  if (now - before.now > 0.5) {
    const factor = (time - before.time) / (now - before.now);
    pace(state === "running" ? factor : null);
    before = { now, time };
  }
});
