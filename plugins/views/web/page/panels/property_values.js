// @ts-check
// Formats read-only values: numbers, lists, tables and links to objects.

import { make } from "tatu/lib/dom";
import { t } from "tatu/lib/language";
import { formatNumber } from "tatu/lib/numbers";
import { scene, select } from "tatu/scene/store";

/**
 * Creates a link that selects an object; "none" if the object does not exist.
 * @param {unknown} id
 */
export function objectLink(id) {
  const o = scene.objects.get(Number(id));
  if (!o) return make("span", { className: "fixed", textContent: t`none` });
  const button = make("button", { type: "button", className: "link", textContent: o.alias, title: t`Select ${o.alias}` });
  button.onclick = () => select(o.id);
  return button;
}

/**
 * Returns a value for display, with links to the objects that it refers to.
 * @param {unknown} value
 * @param {number} [factor] by which numbers are multiplied for display
 * @returns {Node}
 */
export function formatValue(value, factor = 1) {
  if (value === null || value === undefined) return document.createTextNode("none");
  if (typeof value === "boolean") return document.createTextNode(value ? t`yes` : t`no`);
  if (typeof value === "number") return document.createTextNode(formatNumber(value, factor));
  if (Array.isArray(value)) return list(value, factor);
  if (typeof value !== "object") return document.createTextNode(String(value));
  if ("number" in value) return document.createTextNode(formatNumber(value));
  if ("object" in value && Object.keys(value).length === 1) return objectLink(value.object);
  if ("bytes" in value && typeof value.bytes === "string") return document.createTextNode(t`${Math.floor(value.bytes.length * 3 / 4)} bytes`);
  if ("pairs" in value && Array.isArray(value.pairs)) return table(value.pairs, factor);
  return table(Object.entries(value), factor);
}

/**
 * Formats a list.
 * @param {unknown[]} values
 * @param {number} factor
 */
function list(values, factor) {
  if (!values.length) return document.createTextNode("none");
  const all = make("span");
  values.forEach((v, i) => all.append(...(i ? [", "] : []), formatValue(v, factor)));
  return all;
}

/**
 * Formats keys and values as a table.
 * @param {[unknown, unknown][]} entries
 * @param {number} factor
 */
function table(entries, factor) {
  if (!entries.length) return document.createTextNode("none");
  const all = make("dl");
  for (const [key, value] of entries) {
    const [dt, dd] = [make("dt"), make("dd")];
    dt.append(formatValue(key));
    dd.append(formatValue(value, factor));
    all.append(dt, dd);
  }
  return all;
}
