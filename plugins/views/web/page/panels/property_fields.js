// @ts-check
// The field of a property. It shows the value, accepts a new one, and reports why a value was refused. Text that is
// being typed is never replaced, and updates do not move the focus.

import { make } from "tatu/lib/dom";
import { readNumber, writeNumber } from "tatu/lib/numbers";
import { newest, reason } from "tatu/net/calls";
import { together } from "tatu/scene/edits";
import { colorOf, formOf, hexOf, partsOf, sent } from "tatu/scene/property_format";
import { link, shown } from "tatu/panels/property_values";

/** @import { PropertyRow } from "tatu/protocol" */
/**
 * A property for which a field is created. `set` sets the property to a value.
 * @typedef {{ row: PropertyRow, name: string, unit: { text: string, factor: number }, settable: boolean,
 *   set: (value: unknown, merge?: string) => Promise<unknown> }} Property
 */
/**
 * A field: its element, whether the element needs the full width of the panel, and the function that shows a new value.
 * @typedef {{ element: HTMLElement, wide: boolean, update: (value: unknown) => void }} Field
 */

/**
 * Waits until a property has been set, and marks the element as invalid if the value was refused. Calls `tell` with the
 * reason, or with an empty string if the value was accepted. Returns a promise of whether it was.
 * @param {Promise<unknown>} done
 * @param {HTMLElement} element
 * @param {(why: string) => void} tell
 */
async function attempt(done, element, tell) {
  try {
    await done;
    element.removeAttribute("aria-invalid");
    tell("");
    return true;
  } catch (thrown) {
    element.setAttribute("aria-invalid", "true");
    tell(reason(thrown));
    return false;
  }
}

/**
 * Creates a text field. Enter, or Ctrl+Enter in a field with several lines, applies the text, and so does moving the
 * focus away; Escape restores the last value.
 * @param {string} label
 * @param {(text: string) => Promise<unknown>} take applies a text
 * @param {(why: string) => void} tell
 * @param {boolean} [isLong] whether the field has several lines
 */
export function typed(label, take, tell, isLong = false) {
  const element = isLong ? make("textarea", { rows: 4 }) : make("input", { type: "text", autocomplete: "off" });
  element.spellcheck = false;
  element.setAttribute("aria-label", label);
  let known = "";
  const commit = async () => {
    const text = element.value;
    if (text === known) return;
    if (await attempt(take(text), element, tell)) known = text;
  };
  element.onchange = commit;
  element.onkeydown = (/** @type {KeyboardEvent} */ e) => {
    if (e.key === "Enter" && (!isLong || e.ctrlKey)) commit();
    else if (e.key === "Escape") {
      e.stopPropagation();
      element.value = known;
      element.removeAttribute("aria-invalid");
      tell("");
      element.select();
    } else return;
    e.preventDefault();
  };
  const update = (/** @type {string} */ text) => {
    const isTyping = document.activeElement === element && element.value !== known;
    if (!isTyping && !element.hasAttribute("aria-invalid") && element.value !== text) element.value = text;
    known = text;
  };
  return { element, update };
}

/**
 * Parses a typed number. Throws a failure if it is invalid.
 * @param {string} text
 * @param {{ text: string, factor: number }} unit
 */
function number(text, unit) {
  const x = readNumber(text, unit.factor);
  if (Number.isNaN(x)) throw { error: `expected a number${unit.text ? ` in ${unit.text}` : ""}, found "${text}"` };
  return x;
}

/**
 * Returns a function that sets a property to successive values of a slider. Values that are outdated before they are
 * sent are skipped.
 * @param {Property["set"]} set
 */
function sliding(set) {
  return newest((/** @type {{ value: unknown, merge: string }} */ { value, merge }) => set(value, merge));
}

/** @param {Property} p @param {(why: string) => void} tell @returns {Field} */
function numberField({ row, name, unit, set }, tell) {
  const { element: input, update } = typed(name, async (text) => set(sent(number(text, unit))), tell);
  input.inputMode = "decimal";
  const element = make("span", { className: "number" });
  element.append(input);
  if (unit.text) element.append(make("span", { className: "unit", textContent: unit.text }));
  const { min, max } = row;
  // A slider cannot set a mask or a large number precisely.
  const isCoarse = row.type === 2 && Number(max) - Number(min) > 1000;
  if (min === undefined || max === undefined || isCoarse) return { element, wide: false, update: (v) => update(writeNumber(v, unit.factor)) };
  const slider = make("input", { type: "range", min: String(min * unit.factor), max: String(max * unit.factor), step: row.type === 2 ? "1" : "any" });
  slider.setAttribute("aria-label", name);
  let merge = "";
  const send = sliding(set);
  slider.oninput = () => {
    merge ||= together();
    update(writeNumber(Number(slider.value)));
    attempt(send({ value: Number(slider.value) / unit.factor, merge }), slider, tell);
  };
  slider.onchange = () => { merge = ""; };
  element.append(slider);
  return {
    element, wide: false,
    update: (v) => {
      if (merge) return;
      update(writeNumber(v, unit.factor));
      slider.value = String(Number(v) * unit.factor);
    },
  };
}

/** @param {Property} p @param {(why: string) => void} tell @returns {Field} */
function partsField({ row, name, unit, set }, tell) {
  const element = make("span", { className: "parts" });
  element.setAttribute("role", "group");
  element.setAttribute("aria-label", name);
  let value = /** @type {unknown[]} */ (row.value);
  const parts = partsOf(row.key, value.length).map((part, i) => {
    const field = typed(`${name} ${part}`, async (text) => {
      const next = [...value];
      next[i] = sent(number(text, unit));
      await set(next);
      value = next;
    }, tell);
    field.element.inputMode = "decimal";
    const label = make("label");
    label.append(make("span", { className: "part", textContent: part }), field.element);
    element.append(label);
    return field;
  });
  if (unit.text) element.append(make("span", { className: "unit", textContent: unit.text }));
  return {
    element, wide: true,
    update: (v) => {
      value = /** @type {unknown[]} */ (v);
      parts.forEach((part, i) => part.update(writeNumber(value[i], unit.factor)));
    },
  };
}

/** @param {Property} p @param {(why: string) => void} tell @returns {Field} */
function numbersField({ name, unit, set }, tell) {
  const { element, update } = typed(name, async (text) => set(text.trim() ? text.split(",").map((t) => sent(number(t, unit))) : []), tell);
  return { element, wide: true, update: (v) => update(Array.isArray(v) ? v.map((x) => writeNumber(x, unit.factor)).join(", ") : "") };
}

/** @param {Property} p @param {(why: string) => void} tell @returns {Field} */
function textsField({ name, set }, tell) {
  const { element, update } = typed(name, async (text) => set(text.split(",").map((t) => t.trim()).filter(Boolean)), tell);
  element.placeholder = "separated by commas";
  return { element, wide: true, update: (v) => update(Array.isArray(v) ? v.join(", ") : "") };
}

/** @param {Property} p @param {(why: string) => void} tell @returns {Field} */
function checkField({ name, set }, tell) {
  const element = make("input", { type: "checkbox" });
  element.setAttribute("aria-label", name);
  let known = false;
  element.onchange = async () => {
    const wanted = element.checked;
    if (await attempt(set(wanted), element, tell)) known = wanted;
    else element.checked = known;
  };
  return { element, wide: false, update: (v) => { element.checked = known = v === true; } };
}

/** @param {Property} p @param {(why: string) => void} tell @returns {Field} */
function choiceField({ row, name, set }, tell) {
  const element = make("select");
  element.setAttribute("aria-label", name);
  for (const c of row.choices) element.add(new Option(c.replaceAll("_", " "), c));
  let known = "";
  element.onchange = async () => {
    const wanted = element.value;
    if (await attempt(set(wanted), element, tell)) known = wanted;
    else element.value = known;
  };
  element.onkeydown = (e) => {
    if (e.key !== "Escape") return;
    element.removeAttribute("aria-invalid");
    tell("");
  };
  return { element, wide: false, update: (v) => { if (v !== known) element.value = known = String(v ?? ""); } };
}

/** @param {Property} p @param {(why: string) => void} tell @returns {Field} */
function colorField({ name, set }, tell) {
  const element = make("input", { type: "color" });
  element.setAttribute("aria-label", name);
  let merge = "";
  const send = sliding(set);
  element.oninput = () => {
    merge ||= together();
    attempt(send({ value: colorOf(element.value), merge }), element, tell);
  };
  element.onchange = () => { merge = ""; };
  return { element, wide: false, update: (v) => { if (!merge) element.value = hexOf(/** @type {number[]} */ (v)); } };
}

/** @param {Property} p @returns {Field} */
function fixedField({ row, unit }) {
  const element = make("span", { className: "fixed" });
  const isObject = formOf(row) === "object";
  let known = "";
  return {
    element, wide: formOf(row) === "table" || (Array.isArray(row.value) && row.value.length > 2),
    update: (v) => {
      // The elements of an unchanged value are kept, so that links in it keep the focus.
      if (JSON.stringify(v) === known) return;
      known = JSON.stringify(v);
      const hasUnit = !isObject && unit.text && (typeof v === "number" || (Array.isArray(v) && v.length > 0));
      element.replaceChildren(isObject ? link(v) : shown(v, unit.factor), hasUnit ? ` ${unit.text}` : "");
    },
  };
}

/** @param {Property} p @param {(why: string) => void} tell @returns {Field} */
function textField({ row, name, set }, tell) {
  const isLong = String(row.value).includes("\n");
  const { element, update } = typed(name, set, tell, isLong);
  return { element, wide: isLong, update: (v) => update(v === null ? "" : String(v)) };
}

const SETTABLE = {
  number: numberField, parts: partsField, numbers: numbersField, texts: textsField, check: checkField, choice: choiceField,
  color: colorField, text: textField,
};

/**
 * Creates the field of a property.
 * @param {Property} property
 * @param {(why: string) => void} tell shows why a value was refused; called with an empty string if it was accepted
 * @returns {Field}
 */
export function fieldOf(property, tell) {
  const form = formOf(property.row);
  const make = property.settable && form !== "object" && form !== "table" ? SETTABLE[form] : fixedField;
  const field = make(property, tell);
  field.update(property.row.value);
  return field;
}
