// @ts-check
// The toolbar for moving and rotating objects: the frame of reference, and fields for coordinates.

import { get, make } from "tatu/lib/dom";
import { compose, frameOf, inverse, positionOf, rotationOf, shift, spin } from "tatu/lib/poses";
import { conjugate, fromDegrees, multiply, toDegrees } from "tatu/lib/rotations";
import { reason } from "tatu/net/calls";
import { VERB, how, pivot, setHow, watchHow } from "tatu/edit/gizmo";
import { step } from "tatu/edit/nudge_keys";
import { Carry, carried, placeOf } from "tatu/edit/pose_edit";

/** @import { Frame } from "tatu/lib/poses" */
/** @import { Vec3 } from "tatu/lib/vectors" */
/** @import { Place } from "tatu/edit/pose_edit" */

/** Interval at which the coordinates are updated, ms. */
const OFTEN = 250;
/** @type {[Frame, string, string][]} */
const FRAMES = [
  ["world", "World", "Along the axes of the world"], ["parent", "Parent", "Along the axes of the parent, as in scene files"],
  ["own", "Own", "Along the object's own axes; values are relative to the current pose"],
];
const AXES = ["x", "y", "z"];

const bar = make("div", { className: "typed", hidden: true });
bar.setAttribute("role", "toolbar");
bar.setAttribute("aria-label", "Position and orientation");
const what = make("strong");
const frames = make("select", { title: "Whose axes" });
frames.setAttribute("aria-label", "Axes");
for (const [frame, name, title] of FRAMES) {
  const option = new Option(name, frame);
  option.title = title;
  frames.add(option);
}
frames.onchange = () => setHow({ frame: /** @type {Frame} */ (frames.value) });
const why = make("span", { className: "why" });
why.setAttribute("role", "alert");
const unit = make("span", { className: "unit" });
const fields = AXES.map((name, i) => {
  const only = make("button", { textContent: name, className: `axis ${name}`, title: `Restrict to this axis (${name.toUpperCase()})` });
  only.setAttribute("aria-label", `Only ${name}`);
  only.onclick = () => setHow({ only: how.only === i ? -1 : i });
  const field = make("input", { type: "text", inputMode: "decimal", autocomplete: "off", size: 8 });
  field.setAttribute("aria-label", name);
  return { only, field, shown: "" };
});
bar.append(what, frames, ...fields.flatMap(({ only, field }) => [only, field]), unit, why);
const view = get("view");
view.append(bar);

/**
 * Returns the coordinates of an object in the chosen frame: its position, m, or its orientation, degrees.
 * @param {Place} of
 * @returns {Vec3}
 */
function numbersOf(of) {
  const within = compose(inverse(frameOf(how.frame, of)), of.world);
  return how.mode === "rotate" ? toDegrees(rotationOf(within)) : positionOf(within);
}

/** Formats a coordinate. @param {number} x m or degrees */
function written(x) {
  return String(Number(x.toFixed(how.mode === "rotate" ? 4 : 6)) + 0);
}

/** Shows an error; "": none. @param {string} text */
function tell(text) {
  why.textContent = text;
}

/** Requests the coordinates of the object, and shows them. */
async function refresh() {
  const id = pivot();
  if (!id) return;
  const now = await placeOf(id).then(numbersOf).catch(() => null);
  if (!now || id !== pivot()) return;
  fields.forEach((f, i) => {
    const text = written(now[i] ?? 0);
    // The text of a field that is being edited is not replaced.
    if (document.activeElement === f.field && f.field.value !== f.shown) f.shown = text;
    else f.field.value = f.shown = text;
  });
}

/**
 * Moves or rotates the selection so that one coordinate of the object has a value.
 * @param {number} i 0: x; 1: y; 2: z
 * @param {number} to m or degrees
 */
async function apply(i, to) {
  const [id, { mode, frame }] = [pivot(), { ...how }];
  if (!id || !mode) return;
  const carry = await Carry.take(VERB[mode], carried());
  const of = carry.from(id);
  if (!of) return;
  const axes = frameOf(frame, of);
  const numbers = numbersOf(of);
  if (mode === "translate") {
    /** @type {Vec3} */
    const by = [0, 0, 0];
    by[i] = to - (numbers[i] ?? 0);
    await carry.put(shift(axes, by));
    return;
  }
  const now = rotationOf(compose(inverse(axes), of.world));
  numbers[i] = to;
  await carry.put(spin(axes, multiply(fromDegrees(numbers), conjugate(now)), positionOf(of.world)));
}

/**
 * Applies the text of a field, and shows an error if it is invalid.
 * @param {number} i
 * @param {string} text
 */
async function take(i, text) {
  const f = fields[i];
  if (!f) return;
  const to = text.trim() === "" ? NaN : Number(text.trim().replace(",", "."));
  try {
    if (!Number.isFinite(to)) throw { error: `expected a number in ${how.mode === "rotate" ? "degrees" : "m"}` };
    f.shown = f.field.value;
    await apply(i, to);
    f.field.removeAttribute("aria-invalid");
    tell("");
    await refresh();
  } catch (thrown) {
    f.shown = "";
    f.field.setAttribute("aria-invalid", "true");
    tell(reason(thrown));
  }
}

fields.forEach(({ field }, i) => {
  field.onfocus = () => field.select();
  const takeNew = () => { if (field.value !== fields[i]?.shown) take(i, field.value); };
  field.onchange = takeNew;
  field.onkeydown = (e) => {
    if (e.key === "Enter") takeNew();
    else if (e.key === "ArrowUp" || e.key === "ArrowDown") {
      const next = Number(field.value) + (e.key === "ArrowUp" ? 1 : -1) * step(e.shiftKey);
      if (!Number.isFinite(next)) return;
      field.value = written(next);
      take(i, field.value);
    } else if (e.key === "Escape") {
      field.value = fields[i]?.shown ?? "";
      field.removeAttribute("aria-invalid");
      tell("");
      view.focus();
      refresh();
    } else return;
    e.preventDefault();
  };
});
// The toolbar is part of the view. Without this loop, the view would pass its keys to the simulation, and rotate the
// camera by a drag on it.
for (const kind of ["keydown", "pointerdown", "pointerup", "wheel"]) bar.addEventListener(kind, (e) => e.stopPropagation());

watchHow(() => {
  bar.hidden = !pivot();
  what.textContent = how.mode ? VERB[how.mode] + (how.frame === "own" ? " by" : " to") : "";
  unit.textContent = how.mode === "rotate" ? "\u00b0" : "m";
  frames.value = how.frame;
  fields.forEach(({ only }, i) => only.setAttribute("aria-pressed", String(how.only === i)));
  tell("");
  refresh();
});
setInterval(() => { if (!document.hidden) refresh(); }, OFTEN);
