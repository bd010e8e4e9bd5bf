// @ts-check
// Sliders for the position of the selected joint, or of all joints of the selected model.

import { get, make } from "tatu/lib/dom";
import { readNumber, writeNumber } from "tatu/lib/numbers";
import { eachEntry } from "tatu/net/binary_messages";
import { newest, reason } from "tatu/net/calls";
import { call, on } from "tatu/net/connection";
import { edit, named, together } from "tatu/scene/edits";
import { unitOf } from "tatu/scene/property_format";
import { rights, scene, select, selected, watch } from "tatu/scene/store";
import { typed } from "tatu/panels/property_fields";

/** @import { SceneObject } from "tatu/protocol" */
/**
 * A joint with its slider. Positions are in rad or m: `range` is that of the slider, `began` the position when the
 * joint was selected, `now` the current position. `sliding` is the value of `merge` during a drag of the slider,
 * otherwise "".
 * @typedef {{ id: number, alias: string, unit: { text: string, factor: number }, range: [number, number], began: number, now: number,
 *   slider: HTMLInputElement, field: { element: HTMLElement, update: (text: string) => void }, live: HTMLElement,
 *   sliding: string }} Slid
 */

/** Slider ranges of joints without limits, to each side: half a revolution, rad; 1 m for prismatic joints. */
const FREE = { turns: Math.PI, slides: 1 };
/** Interval at which velocities and efforts are requested, ms. */
const OFTEN = 500;

const panel = make("details", { className: "group-of-rows joints", open: localStorage.getItem("tatu joints") !== "", hidden: true });
panel.ontoggle = () => localStorage.setItem("tatu joints", panel.open ? "1" : "");
const list = make("div");
const why = make("p", { className: "why" });
why.setAttribute("role", "alert");
const reset = make("button", { type: "button", textContent: "Reset", title: "Move the joints back to their positions at the time of selection" });
const summary = make("summary", { textContent: "Joints" });
panel.append(summary, list, why, reset);
get("rows").before(panel);

/** @type {Map<number, Slid>} */
let joints = new Map();
let isStopped = true;

/**
 * Returns the selected joint, or the joints of the selected model. Spherical joints are omitted.
 * @returns {SceneObject[]}
 */
function wanted() {
  const o = scene.objects.get(selected());
  const moves = (/** @type {SceneObject} */ j) => j.joint !== undefined && j.joint.type !== "spherical";
  if (!o) return [];
  if (moves(o)) return [o];
  if (!o.model) return [];
  return [...scene.objects.values()].filter((j) => {
    if (!moves(j)) return false;
    for (let at = scene.objects.get(j.parent); at; at = scene.objects.get(at.parent)) if (at.id === o.id) return true;
    return false;
  });
}

/**
 * Returns a promise of a joint property, or of null if the property cannot be read.
 * @param {number} id
 * @param {string} key
 */
async function read(id, key) {
  return call("tatu.get", id, `joint.${key}`).then(([value]) => value, () => null);
}

/**
 * Returns the command calls that move a joint to a position. For a joint under position control, they set the target;
 * if the simulation is stopped, they set the position as well, so that the joint does not move when the simulation
 * starts.
 * @param {number} id
 * @param {number} to
 * @returns {Promise<[string, ...unknown[]][]>}
 */
async function callsFor(id, to) {
  const [mode, control] = await Promise.all([read(id, "mode"), read(id, "control")]);
  const isDriven = mode === "dynamic" && control === "position";
  /** @type {[string, ...unknown[]][]} */
  const calls = [];
  if (!isDriven || isStopped) calls.push(["tatu.set", id, "joint.position", to]);
  if (isDriven) calls.push(["tatu.set", id, "joint.target_position", to]);
  return calls;
}

/**
 * Moves a joint to a position.
 * @param {Slid} j
 * @param {number} to rad or m
 * @param {string} [merge]
 */
async function bring(j, to, merge) {
  await edit(`Move ${j.alias}`, await callsFor(j.id, to), merge);
}

/** @param {unknown} thrown */
function refused(thrown) {
  why.textContent = reason(thrown);
}

/** Shows the current position of a joint, except while its slider is dragged. @param {Slid} j */
function show(j) {
  if (j.sliding) return;
  j.slider.value = String(j.now * j.unit.factor);
  j.slider.setAttribute("aria-valuetext", `${writeNumber(j.now, j.unit.factor)} ${j.unit.text}`);
  j.field.update(writeNumber(Number((j.now * j.unit.factor).toFixed(4))));
}

/**
 * Creates the slider of a joint.
 * @param {SceneObject} o
 * @returns {Promise<Slid>}
 */
async function slid(o) {
  const slides = o.joint?.type === "prismatic";
  const [limits, cyclic, position] = await Promise.all([read(o.id, "limits"), read(o.id, "cyclic"), read(o.id, "position")]);
  const unit = unitOf("rad|m", slides);
  const free = slides ? FREE.slides : FREE.turns;
  const bounded = !cyclic && Array.isArray(limits) && limits.every(Number.isFinite) && limits[0] < limits[1];
  /** @type {[number, number]} */
  const range = bounded ? [limits[0], limits[1]] : [-free, free];
  const slider = make("input", {
    type: "range", min: String(range[0] * unit.factor), max: String(range[1] * unit.factor), step: "any", disabled: !rights.acts,
  });
  slider.setAttribute("aria-label", `Position of ${o.alias}`);
  const field = typed(`Position of ${o.alias} in ${slides ? "m" : "degrees"}`, async (text) => {
    const to = readNumber(text, unit.factor);
    if (!Number.isFinite(to)) throw { error: `expected a number in ${unit.text}, found "${text}"` };
    await bring(j, to);
  }, (text) => { why.textContent = text; });
  /** @type {Slid} */
  const j = { id: o.id, alias: o.alias, unit, range, began: position ?? 0, now: position ?? 0, slider, field, live: make("span", { className: "live" }), sliding: "" };
  const send = newest((/** @type {{ to: number, merge: string }} */ { to, merge }) => bring(j, to, merge));
  slider.oninput = () => {
    j.sliding ||= together();
    field.update(writeNumber(Number(Number(slider.value).toFixed(4))));
    send({ to: Number(slider.value) / unit.factor, merge: j.sliding }).then(() => { why.textContent = ""; }, refused);
  };
  slider.onchange = () => { j.sliding = ""; };
  return j;
}

/** The joints with sliders, as a string for comparison. */
let known = "";
/** Returns the displayed data of joints as a string for comparison. @param {SceneObject[]} all */
function told(all) {
  return JSON.stringify(all.map((j) => [j.id, j.alias, j.joint]));
}

/** Number of the last call of `build`; earlier calls that are still waiting for answers are abandoned. */
let made = 0;
/** Creates the sliders for the selection. */
async function build() {
  const own = ++made;
  const all = wanted();
  known = told(all);
  if (!all.length) {
    joints = new Map();
    panel.hidden = true;
    return;
  }
  const found = await Promise.all(all.map(slid));
  if (own !== made) return;
  joints = new Map(found.map((j) => [j.id, j]));
  why.textContent = "";
  list.replaceChildren(...found.map((j) => {
    const row = make("div", { className: "joint" });
    const name = make("button", { type: "button", className: "link", textContent: j.alias, title: `Select ${j.alias}` });
    name.onclick = () => select(j.id);
    row.append(name, j.field.element, make("span", { className: "unit", textContent: j.unit.text }), j.slider, j.live);
    show(j);
    return row;
  }));
  summary.textContent = found.length === 1 ? "Joint position" : `Joints (${found.length})`;
  reset.hidden = !rights.acts;
  panel.hidden = false;
  ask();
}

reset.onclick = async () => {
  try {
    const calls = await Promise.all([...joints.values()].map((j) => callsFor(j.id, j.began)));
    await edit(`Reset joints of ${named([selected()])}`, calls.flat());
    why.textContent = "";
  } catch (thrown) {
    refused(thrown);
  }
};

/** Requests the velocities and efforts of the joints, and shows them. */
function ask() {
  if (panel.hidden || !panel.open || document.hidden || !rights.acts) return;
  for (const j of joints.values()) {
    Promise.all([read(j.id, "velocity"), read(j.id, "effort")]).then(([velocity, effort]) => {
      const slides = j.unit.factor === 1;
      const [v, e] = [unitOf("rad/s|m/s", slides), unitOf("N m|N", slides)];
      const few = (/** @type {number | null} */ x, /** @type {{ text: string, factor: number }} */ u) => `${Number(((x ?? 0) * u.factor).toFixed(2)) + 0} ${u.text}`;
      j.live.textContent = `${few(velocity, v)}, ${few(effort, e)}`;
    });
  }
}
setInterval(ask, OFTEN);

on("state", ({ state }) => { isStopped = state === "stopped"; });
on("frame", (view) => {
  if (!joints.size) return;
  eachEntry(view, (id, what, numbers) => {
    const j = joints.get(id);
    if (!j || what !== "position") return;
    j.now = numbers[0] ?? 0;
    show(j);
  });
});
watch("selected", build);
/** The limits of the selected joint, as a string for comparison. */
let limits = "";
on("details", ({ object, rows }) => {
  if (!joints.has(object)) return;
  const now = JSON.stringify([object, ...rows.filter(({ key }) => key === "joint.limits" || key === "joint.cyclic").map(({ value }) => value)]);
  if (limits && limits !== now && JSON.parse(limits)[0] === object) build();
  limits = now;
});
for (const news of /** @type {const} */ (["scene", "objects"])) {
  watch(news, () => {
    if (told(wanted()) !== known) build();
  });
}
