// @ts-check
// The controls for play, pause, step, stop and speed, and the display of the simulation time. Before a run starts or
// continues, it takes the text in the script editor.

import { get } from "tatu/lib/dom";
import { t } from "tatu/lib/language";
import { timeOf } from "tatu/net/binary_messages";
import { on, send } from "tatu/net/connection";
import { writeLine } from "tatu/scene/messages";
import { hasTextsToSave, saveTexts } from "tatu/documents/scene_file";

/** @import { RunAction, RunState } from "tatu/protocol" */

const SPEEDS = [0.125, 0.25, 0.5, 1, 1.5, 2, 3, 4, 6, 8, 10, 15, 20, 40];
/** @type {RunState} */
let state = "stopped";
let speed = 1;
let dt = 0.05;

/**
 * Sends a `run` request. A run starts or continues with the text in the script editor, or not at all if that text cannot be
 * loaded.
 * @param {RunAction} action
 */
async function sendAction(action) {
  const goesOn = action === "start" || action === "step";
  if (goesOn && hasTextsToSave() && !(await saveTexts())) {
    writeLine("Status", t`Not started, because the new text of the script is not in the scene`, "warning");
    return;
  }
  send({ type: "run", action });
}

get("play").onclick = () => sendAction("start");
get("pause").onclick = () => sendAction("pause");
get("step").onclick = () => sendAction("step");
get("stop").onclick = () => sendAction("stop");
document.addEventListener("keydown", (e) => {
  if (e.key === "F5") sendAction(state === "running" ? "pause" : "start");
  else if (e.key === "F6") sendAction("step");
  else if (e.key === "F7") sendAction("stop");
  else return;
  e.preventDefault();
});

/** Changes to the next higher or lower speed. @param {boolean} faster */
function changeSpeed(faster) {
  const next = faster ? SPEEDS.find((s) => s > speed) : SPEEDS.findLast((s) => s < speed);
  if (next) send({ type: "speed", speed: next });
}
get("faster").onclick = () => changeSpeed(true);
get("slower").onclick = () => changeSpeed(false);

on("state", (message) => {
  ({ state, speed, dt } = message);
  get("play").classList.toggle("on", state === "running");
  get("pause").classList.toggle("on", state === "paused");
  get("stop").classList.toggle("on", state === "stopped");
  get("stop", HTMLButtonElement).disabled = state === "stopped";
  if (state === "stopped") get("time").textContent = formatTime(0);
  if (state !== "running") showPace(null);
  get("speed").textContent = speed > 0 ? `${speed}x` : "max";
});

/**
 * Formats a time as hours:minutes:seconds with hundredths.
 * @param {number} t s
 */
function formatTime(t) {
  const pad = (/** @type {number} */ x) => String(x).padStart(2, "0");
  return `${pad(Math.floor(t / 3600))}:${pad(Math.floor(t / 60) % 60)}:${(t % 60).toFixed(2).padStart(5, "0")}`;
}

/**
 * Shows the length of a step, and the speed of the simulation.
 * @param {number | null} factor multiple of real time; null: not shown
 */
function showPace(factor) {
  const step = `dt ${+(dt * 1000).toFixed(3)} ms`;
  get("factor").textContent = factor === null ? step : `${step} \u00B7 ${factor < 0.1 ? factor.toPrecision(1) : factor.toFixed(2)}x`;
}

/** @type {{ now: number, time: number } | null} */
let lastSample = null;
on("frame", (view) => {
  // While the simulation is stopped, time 0 is shown, at which the next run starts.
  const time = state === "stopped" ? 0 : timeOf(view);
  get("time").textContent = formatTime(time);
  const now = performance.now() / 1000;
  if (!lastSample || time < lastSample.time) lastSample = { now, time };
  if (now - lastSample.now > 0.5) {
    const factor = (time - lastSample.time) / (now - lastSample.now);
    showPace(state === "running" ? factor : null);
    lastSample = { now, time };
  }
});
