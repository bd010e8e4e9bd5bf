// @ts-check
// Sliders for the position of the selected joint, or of all joints of the selected model.

import { get, make } from "tatu/lib/dom";
import { evaluate } from "tatu/lib/expressions";
import { t } from "tatu/lib/language";
import { formatNumber } from "tatu/lib/numbers";
import { eachEntry } from "tatu/net/binary_messages";
import { reason, sendLatest } from "tatu/net/calls";
import { on } from "tatu/net/connection";
import { describeObjects, edit, newMergeKey } from "tatu/scene/edits";
import { unitOf } from "tatu/scene/property_format";
import { rights, scene, select, selected, watch } from "tatu/scene/store";
import { callsToMoveJoint, readJoint } from "tatu/edit/joint_moves";
import { textInput } from "tatu/panels/property_fields";

/** @import { SceneObject } from "tatu/protocol" */
/**
 * A joint with its slider. Positions are in rad or m: `range` is that of the slider, `began` the position when the
 * joint was selected, `now` the current position. `isPassive` is set if no motor drives the joint. `sliding` is the value
 * of `merge` during a drag of the slider, otherwise "".
 * @typedef {{ id: number, alias: string, isPassive: boolean, unit: { text: string, factor: number }, range: [number, number], began: number, now: number,
 *   slider: HTMLInputElement, field: { element: HTMLElement, update: (text: string) => void }, live: HTMLElement,
 *   sliding: string }} JointSlider
 */

/** Slider ranges of joints without limits, to each side: half a revolution, rad; 1 m for prismatic joints. */
const FREE_RANGE = { turns: Math.PI, slides: 1 };
/** Interval at which velocities and efforts are requested, ms. */
const REFRESH_INTERVAL = 500;

const panel = make("details", { className: "group-of-rows joints", open: localStorage.getItem("tatu joints") !== "", hidden: true });
panel.ontoggle = () => localStorage.setItem("tatu joints", panel.open ? "1" : "");
const list = make("div");
const errorText = make("p", { className: "why" });
errorText.setAttribute("role", "alert");
const reset = make("button", { type: "button", textContent: t`Reset`, title: t`Move the joints back to their positions at the time of selection` });
const summary = make("summary", { textContent: t`Joints` });
panel.append(summary, list, errorText, reset);
get("rows").before(panel);

/** @type {Map<number, JointSlider>} */
let joints = new Map();

/**
 * Returns the selected joint, or the joints of the selected model. Spherical joints are omitted.
 * @returns {SceneObject[]}
 */
function selectedJoints() {
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
 * Moves a joint to a position.
 * @param {JointSlider} j
 * @param {number} to rad or m
 * @param {string} [merge]
 */
async function moveJoint(j, to, merge) {
  await edit(t`Move ${j.alias}`, await callsToMoveJoint(j.id, to), merge);
}

/** @param {unknown} thrown */
function showError(thrown) {
  errorText.textContent = reason(thrown);
}

/** Shows the current position of a joint, except while its slider is dragged. @param {JointSlider} j */
function show(j) {
  if (j.sliding) return;
  j.slider.value = String(j.now * j.unit.factor);
  j.slider.setAttribute("aria-valuetext", `${formatNumber(j.now, j.unit.factor)} ${j.unit.text}`);
  j.field.update(formatNumber(Number((j.now * j.unit.factor).toFixed(4))));
}

/**
 * Creates the slider of a joint.
 * @param {SceneObject} o
 * @returns {Promise<JointSlider>}
 */
async function createSlider(o) {
  const isPrismatic = o.joint?.type === "prismatic";
  const [limits, cyclic, position, mode, control] = await Promise.all(["limits", "cyclic", "position", "mode", "control"].map((key) => readJoint(o.id, key)));
  const unit = unitOf("rad|m", isPrismatic);
  const free = isPrismatic ? FREE_RANGE.slides : FREE_RANGE.turns;
  const bounded = !cyclic && Array.isArray(limits) && limits.every(Number.isFinite) && limits[0] < limits[1];
  /** @type {[number, number]} */
  const range = bounded ? [limits[0], limits[1]] : [-free, free];
  const slider = make("input", {
    type: "range", min: String(range[0] * unit.factor), max: String(range[1] * unit.factor), step: "any", disabled: !rights.canControl,
  });
  slider.setAttribute("aria-label", t`Position of ${o.alias}`);
  const field = textInput(t`Position of ${o.alias} in ${isPrismatic ? "m" : t`degrees`}`, async (text) => {
    const to = evaluate(text, unit.text) / unit.factor;
    if (!Number.isFinite(to)) throw { error: t`expected a number in ${unit.text}, found "${text}"` };
    await moveJoint(j, to);
  }, (text) => { errorText.textContent = text; });
  /** @type {JointSlider} */
  const j = { id: o.id, alias: o.alias, unit, range, isPassive: mode === "dynamic" && (control === "free" || control === "spring"), began: position ?? 0, now: position ?? 0, slider, field, live: make("span", { className: "live" }), sliding: "" };
  const send = sendLatest((/** @type {{ to: number, merge: string }} */ { to, merge }) => moveJoint(j, to, merge));
  slider.oninput = () => {
    j.sliding ||= newMergeKey();
    field.update(formatNumber(Number(Number(slider.value).toFixed(4))));
    send({ to: Number(slider.value) / unit.factor, merge: j.sliding }).then(() => { errorText.textContent = ""; }, showError);
  };
  slider.onchange = () => { j.sliding = ""; };
  return j;
}

/** Creates the row that shows a joint. @param {JointSlider} j */
function rowOf(j) {
  const row = make("div", { className: "joint" });
  const name = make("button", { type: "button", className: "link", textContent: j.alias, title: t`Select ${j.alias}` });
  name.onclick = () => select(j.id);
  row.append(name, j.field.element, make("span", { className: "unit", textContent: j.unit.text }), j.slider, j.live);
  show(j);
  return row;
}

/** The joints with sliders, as a string for comparison. */
let shownSignature = "";
/** Returns the displayed data of joints as a string for comparison. @param {SceneObject[]} all */
function signatureOf(all) {
  return JSON.stringify(all.map((j) => [j.id, j.alias, j.joint]));
}

/** Number of the last call of `build`; earlier calls that are still waiting for answers are abandoned. */
let buildCount = 0;
/** Creates the sliders for the selection. */
async function build() {
  const number = ++buildCount;
  const all = selectedJoints();
  shownSignature = signatureOf(all);
  if (!all.length) {
    joints = new Map();
    panel.hidden = true;
    return;
  }
  const found = await Promise.all(all.map(createSlider));
  if (number !== buildCount) return;
  joints = new Map(found.map((j) => [j.id, j]));
  errorText.textContent = "";
  const passive = found.filter((j) => j.isPassive);
  if (passive.length && passive.length < found.length) {
    const folded = make("details", { className: "passive" });
    folded.append(make("summary", { textContent: t`Passive joints (${passive.length})` }), ...passive.map(rowOf));
    list.replaceChildren(...found.filter((j) => !j.isPassive).map(rowOf), folded);
  } else list.replaceChildren(...found.map(rowOf));
  summary.textContent = found.length === 1 ? t`Joint position` : t`Joints (${found.length})`;
  reset.hidden = !rights.canControl;
  panel.hidden = false;
  requestMotion();
}

reset.onclick = async () => {
  try {
    const calls = await Promise.all([...joints.values()].map((j) => callsToMoveJoint(j.id, j.began)));
    await edit(t`Reset joints of ${describeObjects([selected()])}`, calls.flat());
    errorText.textContent = "";
  } catch (thrown) {
    showError(thrown);
  }
};

/** Whether time has passed since the last request of velocities and efforts. */
let isOutdated = true;
/** Requests the velocities and efforts of the joints, and shows them. */
function requestMotion() {
  if (panel.hidden || !panel.open || document.hidden || !rights.canControl) return;
  isOutdated = false;
  for (const j of joints.values()) {
    Promise.all([readJoint(j.id, "velocity"), readJoint(j.id, "effort")]).then(([velocity, effort]) => {
      const isPrismatic = j.unit.factor === 1;
      const [v, e] = [unitOf("rad/s|m/s", isPrismatic), unitOf("N m|N", isPrismatic)];
      const formatShort = (/** @type {number | null} */ x, /** @type {{ text: string, factor: number }} */ u) => `${Number(((x ?? 0) * u.factor).toFixed(2)) + 0} ${u.text}`;
      j.live.textContent = `${formatShort(velocity, v)}, ${formatShort(effort, e)}`;
    });
  }
}
setInterval(() => { if (isOutdated) requestMotion(); }, REFRESH_INTERVAL);

on("frame", (view) => {
  isOutdated = true;
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
for (const change of /** @type {const} */ (["scene", "objects"])) {
  watch(change, () => {
    if (signatureOf(selectedJoints()) !== shownSignature) build();
  });
}
