// @ts-check
// The field of a property. It shows the value, accepts a new one, and reports why a value was refused. Text that is
// being typed is never replaced, and updates do not move the focus.

import { make } from "tatu/lib/dom";
import { evaluate } from "tatu/lib/expressions";
import { t } from "tatu/lib/language";
import { formatNumber, formatShort } from "tatu/lib/numbers";
import { reason, sendLatest } from "tatu/net/calls";
import { newMergeKey } from "tatu/scene/edits";
import { colorOf, encodeNumber, formOf, hexOf, partNames } from "tatu/scene/property_format";
import { formatValue, objectLink } from "tatu/panels/property_values";

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
 * Waits until a property has been set, and marks the element as invalid if the value was refused. Calls `showError`
 * with the reason, or with an empty string if the value was accepted. Returns a promise of whether it was.
 * @param {Promise<unknown>} done
 * @param {HTMLElement} element
 * @param {(why: string) => void} showError
 */
async function attempt(done, element, showError) {
  try {
    await done;
    element.removeAttribute("aria-invalid");
    showError("");
    return true;
  } catch (thrown) {
    element.setAttribute("aria-invalid", "true");
    showError(reason(thrown));
    return false;
  }
}

/**
 * Creates a text field. Enter, or Ctrl+Enter in a field with several lines, applies the text, and so does moving the
 * focus away; Escape restores the last value. `update` shows a value, or a shorter text while the field is not in use.
 * @param {string} label
 * @param {(text: string) => Promise<unknown>} applyText applies a text
 * @param {(why: string) => void} showError
 * @param {boolean} [isLong] whether the field has several lines
 */
export function textInput(label, applyText, showError, isLong = false) {
  const element = isLong ? make("textarea", { rows: 4 }) : make("input", { type: "text", autocomplete: "off" });
  element.spellcheck = false;
  element.setAttribute("aria-label", label);
  let current = "";
  const commit = async () => {
    const text = element.value;
    if (text === current) return;
    if (await attempt(applyText(text), element, showError)) current = text;
  };
  element.onchange = commit;
  element.onkeydown = (/** @type {KeyboardEvent} */ e) => {
    if (e.key === "Enter" && (!isLong || e.ctrlKey)) commit();
    else if (e.key === "Escape") {
      e.stopPropagation();
      element.value = current;
      element.removeAttribute("aria-invalid");
      showError("");
      element.select();
    } else return;
    e.preventDefault();
  };
  let short = "";
  element.onfocus = () => { if (element.value === short) element.value = current; };
  element.onblur = () => { if (element.value === current) element.value = short; };
  const update = (/** @type {string} */ text, /** @type {string} */ shortText = text) => {
    const hasFocus = document.activeElement === element;
    const isTyping = hasFocus && element.value !== current;
    const shown = hasFocus ? text : shortText;
    if (!isTyping && !element.hasAttribute("aria-invalid") && element.value !== shown) element.value = shown;
    [current, short] = [text, shortText];
    element.title = text === shortText ? "" : text;
  };
  return { element, update };
}

/**
 * Evaluates a typed number. Throws a failure if it is invalid.
 * @param {string} text
 * @param {{ text: string, factor: number }} unit
 */
function number(text, unit) {
  return evaluate(text, unit.text) / unit.factor;
}

/**
 * Returns a function that sets a property to successive values of a slider. Values that are outdated before they are
 * sent are skipped.
 * @param {Property["set"]} set
 */
function latestSetter(set) {
  return sendLatest((/** @type {{ value: unknown, merge: string }} */ { value, merge }) => set(value, merge));
}

/** @param {Property} p @param {(why: string) => void} showError @returns {Field} */
function numberField({ row, name, unit, set }, showError) {
  const { element: input, update } = textInput(name, async (text) => set(encodeNumber(number(text, unit))), showError);
  input.inputMode = "decimal";
  const element = make("span", { className: "number" });
  element.append(input);
  if (unit.text) element.append(make("span", { className: "unit", textContent: unit.text }));
  const { min, max } = row;
  // A slider cannot set a mask or a large number precisely.
  const isCoarse = row.type === 2 && Number(max) - Number(min) > 1000;
  if (min === undefined || max === undefined || isCoarse) return { element, wide: false, update: (v) => update(formatNumber(v, unit.factor)) };
  const slider = make("input", { type: "range", min: String(min * unit.factor), max: String(max * unit.factor), step: row.type === 2 ? "1" : "any" });
  slider.setAttribute("aria-label", name);
  let merge = "";
  const send = latestSetter(set);
  slider.oninput = () => {
    merge ||= newMergeKey();
    update(formatNumber(Number(slider.value)));
    attempt(send({ value: Number(slider.value) / unit.factor, merge }), slider, showError);
  };
  slider.onchange = () => { merge = ""; };
  element.append(slider);
  return {
    element, wide: false,
    update: (v) => {
      if (merge) return;
      update(formatNumber(v, unit.factor));
      slider.value = String(Number(v) * unit.factor);
    },
  };
}

/** @param {Property} p @param {(why: string) => void} showError @returns {Field} */
function partsField({ row, name, unit, set }, showError) {
  const element = make("span", { className: "parts" });
  element.setAttribute("role", "group");
  element.setAttribute("aria-label", name);
  let value = /** @type {unknown[]} */ (row.value);
  const parts = partNames(row.key, value.length).map((part, i) => {
    const field = textInput(`${name} ${part}`, async (text) => {
      const next = [...value];
      next[i] = encodeNumber(number(text, unit));
      await set(next);
      value = next;
    }, showError);
    field.element.inputMode = "decimal";
    const label = make("label");
    label.append(make("span", { className: `part ${part}`, textContent: part }), field.element);
    element.append(label);
    return field;
  });
  if (unit.text) element.append(make("span", { className: "unit", textContent: unit.text }));
  return {
    element, wide: true,
    update: (v) => {
      value = /** @type {unknown[]} */ (v);
      parts.forEach((part, i) => part.update(formatNumber(value[i], unit.factor), formatShort(value[i], unit.factor)));
    },
  };
}

/** @param {Property} p @param {(why: string) => void} showError @returns {Field} */
function numbersField({ name, unit, set }, showError) {
  const { element, update } = textInput(name, async (text) => set(text.trim() ? text.split(",").map((t) => encodeNumber(number(t, unit))) : []), showError);
  return { element, wide: true, update: (v) => update(Array.isArray(v) ? v.map((x) => formatNumber(x, unit.factor)).join(", ") : "") };
}

/** @param {Property} p @param {(why: string) => void} showError @returns {Field} */
function textsField({ name, set }, showError) {
  const { element, update } = textInput(name, async (text) => set(text.split(",").map((t) => t.trim()).filter(Boolean)), showError);
  element.placeholder = t`separated by commas`;
  return { element, wide: true, update: (v) => update(Array.isArray(v) ? v.join(", ") : "") };
}

/** @param {Property} p @param {(why: string) => void} showError @returns {Field} */
function checkField({ name, set }, showError) {
  const element = make("input", { type: "checkbox" });
  element.setAttribute("aria-label", name);
  let current = false;
  element.onchange = async () => {
    const requested = element.checked;
    if (await attempt(set(requested), element, showError)) current = requested;
    else element.checked = current;
  };
  return { element, wide: false, update: (v) => { element.checked = current = v === true; } };
}

/** @param {Property} p @param {(why: string) => void} showError @returns {Field} */
function choiceField({ row, name, set }, showError) {
  const element = make("select");
  element.setAttribute("aria-label", name);
  for (const c of row.choices) element.add(new Option(c.replaceAll("_", " "), c));
  let current = "";
  element.onchange = async () => {
    const requested = element.value;
    if (await attempt(set(requested), element, showError)) current = requested;
    else element.value = current;
  };
  element.onkeydown = (e) => {
    if (e.key !== "Escape") return;
    element.removeAttribute("aria-invalid");
    showError("");
  };
  return { element, wide: false, update: (v) => { if (v !== current) element.value = current = String(v ?? ""); } };
}

/** @param {Property} p @param {(why: string) => void} showError @returns {Field} */
function colorField({ name, set }, showError) {
  const element = make("input", { type: "color" });
  element.setAttribute("aria-label", name);
  let merge = "";
  const send = latestSetter(set);
  element.oninput = () => {
    merge ||= newMergeKey();
    attempt(send({ value: colorOf(element.value), merge }), element, showError);
  };
  element.onchange = () => { merge = ""; };
  return { element, wide: false, update: (v) => { if (!merge) element.value = hexOf(/** @type {number[]} */ (v)); } };
}

/** @param {Property} p @returns {Field} */
function fixedField({ row, unit }) {
  const element = make("span", { className: "fixed" });
  const isObject = formOf(row) === "object";
  let current = "";
  return {
    element, wide: formOf(row) === "table" || (Array.isArray(row.value) && row.value.length > 2),
    update: (v) => {
      // The elements of an unchanged value are kept, so that links in it keep the focus.
      if (JSON.stringify(v) === current) return;
      current = JSON.stringify(v);
      const hasUnit = !isObject && unit.text && (typeof v === "number" || (Array.isArray(v) && v.length > 0));
      element.replaceChildren(isObject ? objectLink(v) : formatValue(v, unit.factor), hasUnit ? ` ${unit.text}` : "");
    },
  };
}

/** @param {Property} p @param {(why: string) => void} showError @returns {Field} */
function textField({ row, name, set }, showError) {
  const isLong = String(row.value).includes("\n");
  const { element, update } = textInput(name, set, showError, isLong);
  return { element, wide: isLong, update: (v) => update(v === null ? "" : String(v)) };
}

const SETTABLE = {
  number: numberField, parts: partsField, numbers: numbersField, texts: textsField, check: checkField, choice: choiceField,
  color: colorField, text: textField,
};

/**
 * Creates the field of a property.
 * @param {Property} property
 * @param {(why: string) => void} showError shows why a value was refused; called with an empty string if it was accepted
 * @returns {Field}
 */
export function fieldOf(property, showError) {
  const form = formOf(property.row);
  const make = property.settable && form !== "object" && form !== "table" ? SETTABLE[form] : fixedField;
  const field = make(property, showError);
  field.update(property.row.value);
  return field;
}
