// @ts-check
// Every property of the selection with its unit; those that can be set are fields.

import { failure } from "tatu/calls";
import { get, make } from "tatu/dom";
import { edit } from "tatu/edits";
import { on, send } from "tatu/net";
import { rights, scene, selected, watch } from "tatu/store";

/** @import { Row } from "tatu/protocol" */

const rows = get("rows");
const what = get("what");
let shown = 0;

/**
 * Numbers as people read them.
 * @param {unknown} x
 */
function short(x) {
  if (typeof x === "object" && x !== null && "number" in x) return String(x.number);
  if (typeof x !== "number") return String(x ?? "");
  return Number.isInteger(x) ? String(x) : String(+x.toPrecision(6));
}

/** @param {unknown} value */
function written(value) {
  return Array.isArray(value) ? value.map(short).join(", ") : short(value);
}

/**
 * What was typed, as the type of the value that stood there.
 * @param {string} text
 * @param {unknown} value
 */
function read(text, value) {
  if (Array.isArray(value)) return text.split(",").map(Number);
  if (typeof value === "number") return Number(text);
  if (typeof value === "boolean") return text === "true";
  return text;
}

/**
 * @param {Row} row
 * @param {unknown} value
 * @param {HTMLInputElement | HTMLSelectElement} field
 */
async function set(row, value, field) {
  try {
    if (Array.isArray(value) ? value.some(Number.isNaN) : Number.isNaN(value)) throw { error: "a number is expected" };
    const name = scene.objects.get(shown)?.alias ?? "object";
    await edit(`Change ${row.key.replace(/^\w+\./, "").replaceAll("_", " ")} of ${name}`, [["tatu.set", shown, row.key, value]]);
    field.setCustomValidity("");
    row.value = value;
  } catch (thrown) {
    const e = failure(thrown);
    field.setCustomValidity(e.error);
    field.reportValidity();
  }
}

/** @param {Row} row */
function field(row) {
  const settable = row.settable && rights.acts && row.key !== "object.parent";
  if (!settable) {
    const text = document.createElement("span");
    text.className = "fixed";
    text.textContent = written(row.value) + (row.unit ? ` ${row.unit}` : "");
    return text;
  }
  if (row.choices.length || typeof row.value === "boolean") {
    const list = document.createElement("select");
    const choices = typeof row.value === "boolean" ? ["true", "false"] : row.choices;
    for (const c of choices) list.add(new Option(c, c, false, c === String(row.value)));
    list.onchange = () => set(row, read(list.value, row.value), list);
    return list;
  }
  const input = document.createElement("input");
  input.value = written(row.value);
  input.onkeydown = (e) => { if (e.key === "Enter") input.blur(); e.stopPropagation(); };
  input.onchange = () => set(row, read(input.value, row.value), input);
  return input;
}

on("details", (message) => {
  if (message.object !== selected()) return;
  // What is being typed is not replaced.
  if (shown === message.object && rows.contains(document.activeElement)) return;
  shown = message.object;
  rows.replaceChildren(...message.rows.map((row) => {
    const div = make("div", { className: "row" });
    const name = make("span", { textContent: row.key + (row.settable && row.unit ? ` (${row.unit})` : ""), title: row.text });
    const f = field(row);
    f.setAttribute("aria-label", row.key);
    div.append(name, f);
    return div;
  }));
});

function title() {
  const o = scene.objects.get(selected());
  what.textContent = o ? `${o.alias} \u2014 ${o.sensor ?? o.kind}` : "Nothing is selected";
}

watch("selected", (id) => {
  const o = scene.objects.get(id);
  title();
  rows.replaceChildren();
  get("eye", HTMLCanvasElement).hidden = o?.schema !== "image";
  get("plot", HTMLCanvasElement).hidden = o?.kind !== "graph";
  shown = 0;
  if (o) send({ type: "details", object: id });
});
watch("objects", title);
setInterval(() => { if (selected() && !document.hidden) send({ type: "details", object: selected() }); }, 1000);
