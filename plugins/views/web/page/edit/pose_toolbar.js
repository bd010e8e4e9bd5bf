// @ts-check
// The toolbar for moving and rotating objects: the frame of reference, and fields for coordinates.

import { get, make } from "tatu/lib/dom";
import { evaluate } from "tatu/lib/expressions";
import { t } from "tatu/lib/language";
import { compose, frameOf, inverse, positionOf, rotationAbout, rotationOf, translationAlong } from "tatu/lib/poses";
import { conjugate, fromDegrees, multiply, toDegrees } from "tatu/lib/rotations";
import { hasMotion } from "tatu/net/binary_messages";
import { reason } from "tatu/net/calls";
import { on } from "tatu/net/connection";
import { watch } from "tatu/scene/store";
import { EDIT_VERBS, beginEdit, gizmoObject, moveTool, setMoveTool, watchMoveTool } from "tatu/edit/gizmo";
import { keyStep } from "tatu/edit/move_keys";
import { posesOf } from "tatu/edit/pose_edit";

/** @import { Frame } from "tatu/lib/poses" */
/** @import { Vec3 } from "tatu/lib/vectors" */
/** @import { ObjectPoses } from "tatu/edit/pose_edit" */

/** Interval at which the coordinates are updated, ms. */
const REFRESH_INTERVAL = 250;
/** @type {[Frame, string, string][]} */
const FRAMES = [
  ["world", t`World`, t`Along the axes of the world`], ["parent", t`Parent`, t`Along the axes of the parent, as in scene files`],
  ["own", t`Own`, t`Along the object's own axes; values are relative to the current pose`],
];
const AXES = ["x", "y", "z"];

const bar = make("div", { className: "typed", hidden: true });
bar.setAttribute("role", "toolbar");
bar.setAttribute("aria-label", t`Position and orientation`);
const verbLabel = make("strong");
const frameSelect = make("select", { title: t`Whose axes` });
frameSelect.setAttribute("aria-label", t`Axes`);
for (const [frame, name, title] of FRAMES) {
  const option = new Option(name, frame);
  option.title = title;
  frameSelect.add(option);
}
frameSelect.onchange = () => setMoveTool({ frame: /** @type {Frame} */ (frameSelect.value) });
const errorText = make("span", { className: "why" });
errorText.setAttribute("role", "alert");
const unit = make("span", { className: "unit" });
const fields = AXES.map((name, i) => {
  const only = make("button", { textContent: name, className: `axis ${name}`, title: t`Restrict to this axis (${name.toUpperCase()})` });
  only.setAttribute("aria-label", t`Only ${name}`);
  only.onclick = () => setMoveTool({ freeAxis: moveTool.freeAxis === i ? -1 : i });
  const field = make("input", { type: "text", inputMode: "decimal", autocomplete: "off", size: 8 });
  field.setAttribute("aria-label", name);
  return { only, field, shown: "" };
});
bar.append(verbLabel, frameSelect, ...fields.flatMap(({ only, field }) => [only, field]), unit, errorText);
const view = get("view");
view.append(bar);

/**
 * Returns the coordinates of an object in the chosen frame: its position, m, or its orientation, degrees.
 * @param {ObjectPoses} poses
 * @returns {Vec3}
 */
function coordinatesOf(poses) {
  const within = compose(inverse(frameOf(moveTool.frame, poses)), poses.world);
  return moveTool.mode === "rotate" ? toDegrees(rotationOf(within)) : positionOf(within);
}

/** Formats a coordinate. @param {number} x m or degrees */
function format(x) {
  return String(Number(x.toFixed(moveTool.mode === "rotate" ? 4 : 6)) + 0);
}

/** Shows an error; "": none. @param {string} text */
function showError(text) {
  errorText.textContent = text;
}

/** Requests the coordinates of the object, and shows them. */
async function refresh() {
  const id = gizmoObject();
  if (!id) return;
  const coordinates = await posesOf(id).then(coordinatesOf).catch(() => null);
  if (!coordinates || id !== gizmoObject()) return;
  fields.forEach((f, i) => {
    const text = format(coordinates[i] ?? 0);
    // The text of a field that is being edited is not replaced.
    if (document.activeElement === f.field && f.field.value !== f.shown) f.shown = text;
    else f.field.value = f.shown = text;
  });
}

/**
 * Moves or rotates the selection so that one coordinate of the object has a value.
 * @param {number} i 0: x; 1: y; 2: z
 * @param {number} value m or degrees
 */
async function apply(i, value) {
  const [id, { mode, frame }] = [gizmoObject(), { ...moveTool }];
  if (!id || !mode) return;
  const poseEdit = await beginEdit(mode);
  const initial = poseEdit.initialPoses(id);
  if (!initial) return;
  const frameAxes = frameOf(frame, initial);
  const numbers = coordinatesOf(initial);
  if (mode === "translate") {
    /** @type {Vec3} */
    const displacement = [0, 0, 0];
    displacement[i] = value - (numbers[i] ?? 0);
    await poseEdit.apply(translationAlong(frameAxes, displacement));
    return;
  }
  const rotation = rotationOf(compose(inverse(frameAxes), initial.world));
  numbers[i] = value;
  await poseEdit.apply(rotationAbout(frameAxes, multiply(fromDegrees(numbers), conjugate(rotation)), positionOf(initial.world)));
}

/**
 * Applies the text of a field, and shows an error if it is invalid.
 * @param {number} i
 * @param {string} text
 */
async function applyText(i, text) {
  const f = fields[i];
  if (!f) return;
  try {
    const value = evaluate(text, moveTool.mode === "rotate" ? "\u00b0" : "m");
    if (!Number.isFinite(value)) throw { error: t`expected a number in ${moveTool.mode === "rotate" ? "\u00b0" : "m"}` };
    f.shown = f.field.value;
    await apply(i, value);
    f.field.removeAttribute("aria-invalid");
    showError("");
    await refresh();
  } catch (thrown) {
    f.shown = "";
    f.field.setAttribute("aria-invalid", "true");
    showError(reason(thrown));
  }
}

fields.forEach(({ field }, i) => {
  field.onfocus = () => field.select();
  const applyChanged = () => { if (field.value !== fields[i]?.shown) applyText(i, field.value); };
  field.onchange = applyChanged;
  field.onkeydown = (e) => {
    if (e.key === "Enter") applyChanged();
    else if (e.key === "ArrowUp" || e.key === "ArrowDown") {
      const next = Number(field.value) + (e.key === "ArrowUp" ? 1 : -1) * keyStep(e.shiftKey);
      if (!Number.isFinite(next)) return;
      field.value = format(next);
      applyText(i, field.value);
    } else if (e.key === "Escape") {
      field.value = fields[i]?.shown ?? "";
      field.removeAttribute("aria-invalid");
      showError("");
      view.focus();
      refresh();
    } else return;
    e.preventDefault();
  };
});
// The toolbar is part of the view. Without this loop, the view would pass its keys to the simulation, and rotate the
// camera by a drag on it.
for (const kind of ["keydown", "pointerdown", "pointerup", "wheel"]) bar.addEventListener(kind, (e) => e.stopPropagation());

watchMoveTool(() => {
  bar.hidden = !gizmoObject();
  const verb = moveTool.mode ? (moveTool.guides ? t`Guide` : EDIT_VERBS[moveTool.mode]) : "";
  verbLabel.textContent = !verb ? "" : moveTool.frame === "own" ? t`${verb} by` : t`${verb} to`;
  unit.textContent = moveTool.mode === "rotate" ? "\u00b0" : "m";
  frameSelect.value = moveTool.frame;
  fields.forEach(({ only }, i) => only.setAttribute("aria-pressed", String(moveTool.freeAxis === i)));
  showError("");
  refresh();
});
/** Whether something has moved since the last request of the coordinates. */
let isOutdated = true;
on("frame", (view) => { if (hasMotion(view)) isOutdated = true; });
watch("objects", () => { isOutdated = true; });
setInterval(() => {
  if (!isOutdated || document.hidden || !gizmoObject()) return;
  isOutdated = false;
  refresh();
}, REFRESH_INTERVAL);
