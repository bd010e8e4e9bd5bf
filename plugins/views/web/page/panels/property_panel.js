// @ts-check
// The panel with the properties of the selected object: grouped, with names, units and help. Editable properties have
// input fields.

import { get, make } from "tatu/lib/dom";
import { icon } from "tatu/lib/icons";
import { on, send } from "tatu/net/connection";
import { edit, named } from "tatu/scene/edits";
import { GROUPS, formOf, groupOf, labelOf, nameOf, unitOf } from "tatu/scene/property_format";
import { rights, scene, selected, watch } from "tatu/scene/store";
import { openScript } from "tatu/documents/script_editor";
import { toggle } from "tatu/windows/open_windows";
import { countOf, plotRow } from "tatu/windows/plot_window";
import { windowOf } from "tatu/windows/window_menu";
import { fieldOf } from "tatu/panels/property_fields";

/** @import { PropertyRow } from "tatu/protocol" */
/** @import { Field } from "tatu/panels/property_fields" */
/** @typedef {{ element: HTMLElement, signature: string, row: PropertyRow, field: Field, name: HTMLElement }} Line */

/** Interval at which values are updated, ms. */
const OFTEN = 1000;
const rows = get("rows");
const what = get("what");
let shown = 0;
/** The lines of the object's properties, by key. @type {Map<string, Line>} */
const lines = new Map();
/** @type {Map<string, HTMLElement>} */
const groups = new Map();

const raw = make("input", { type: "checkbox", checked: localStorage.getItem("tatu raw names") === "1" });
const option = make("label", { className: "raw", title: "The keys that scripts and scene files use", hidden: true });
option.append(raw, " Raw names");
rows.before(option);
raw.onchange = () => {
  localStorage.setItem("tatu raw names", raw.checked ? "1" : "");
  for (const { name, row } of lines.values()) name.textContent = called(row);
};

/** Returns the displayed name of a property. @param {PropertyRow} row */
function called(row) {
  return raw.checked ? row.key : nameOf(row.key);
}

/**
 * Returns the element of a group, and creates it if necessary. Whether a group is open is remembered.
 * @param {string} name
 */
function groupNamed(name) {
  const known = groups.get(name);
  if (known) return known;
  const key = `tatu details ${name}`;
  const group = make("details", { className: "group-of-rows", open: (localStorage.getItem(key) ?? (name === "More" ? "" : "1")) === "1" });
  group.append(make("summary", { textContent: name }));
  group.ontoggle = () => localStorage.setItem(key, group.open ? "1" : "");
  group.dataset.group = name;
  groups.set(name, group);
  const place = (/** @type {string} */ n) => (GROUPS.includes(n) ? GROUPS.indexOf(n) : 0.5);
  const after = [...rows.children].find((e) => e instanceof HTMLElement && place(e.dataset.group ?? "") > place(name));
  rows.insertBefore(group, after ?? null);
  return group;
}

/**
 * Sets a property of an object, which can be undone.
 * @param {number} id
 * @param {string} key
 * @param {unknown} value
 * @param {string} [merge]
 */
async function set(id, key, value, merge) {
  await edit(labelOf(key, named([id])), [["tatu.set", id, key, value]], merge);
  send({ type: "details", object: id });
}

/**
 * Returns a string that encodes everything that determines how a field is built. While it does not change, only the
 * value of the field is updated.
 * @param {PropertyRow} row
 * @param {boolean} slides
 */
function signatureOf(row, slides) {
  const form = formOf(row);
  const length = form === "parts" && Array.isArray(row.value) ? row.value.length : 0;
  const isLong = form === "text" && String(row.value).includes("\n");
  return JSON.stringify([form, length, isLong, row.settable && rights.acts, row.choices, slides, row.min, row.max]);
}

/**
 * Creates the line of a property.
 * @param {PropertyRow} row
 * @param {boolean} slides whether the object is a prismatic joint
 * @param {string} signature
 * @returns {Line}
 */
function lineOf(row, slides, signature) {
  const id = shown;
  const element = make("div", { className: "row" });
  element.dataset.key = row.key;
  const name = make("span", { className: "name", textContent: called(row), title: `${row.text} (${row.key})` });
  const why = make("p", { className: "why" });
  why.setAttribute("role", "alert");
  const settable = row.settable && rights.acts;
  const set1 = (/** @type {unknown} */ value, /** @type {string} */ merge = "") => set(id, row.key, value, merge);
  const field = fieldOf({ row, name: nameOf(row.key), unit: unitOf(row.unit, slides), settable, set: set1 }, (text) => { why.textContent = text; });
  const help = make("p", { className: "help", textContent: row.text, hidden: true });
  const ask = make("button", { type: "button", className: "ask", textContent: "?", hidden: !row.text });
  ask.setAttribute("aria-label", `What is ${nameOf(row.key)}?`);
  ask.setAttribute("aria-expanded", "false");
  ask.onclick = () => {
    help.hidden = !help.hidden;
    ask.setAttribute("aria-expanded", String(!help.hidden));
  };
  const head = make("span", { className: "head" });
  head.append(name, ask);
  if (countOf(row)) {
    const chart = make("button", { type: "button", className: "ask chart", title: "Plot (Shift: in a new window)" });
    chart.setAttribute("aria-label", `Plot ${nameOf(row.key)}`);
    chart.append(icon("graph"));
    chart.onclick = (e) => plotRow(id, row, e.shiftKey);
    head.append(chart);
  }
  element.classList.toggle("wide", field.wide);
  element.append(head, field.element, why, help);
  return { element, signature, row, field, name };
}

on("details", (message) => {
  if (message.object !== selected()) return;
  if (shown !== message.object) clear();
  shown = message.object;
  const kind = scene.objects.get(shown)?.kind ?? "";
  const slides = message.rows.some((row) => row.key === "joint.type" && row.value === "prismatic");
  const gone = new Set(lines.keys());
  for (const row of message.rows) {
    // The drive is omitted for objects that do not have one.
    if (row.key === "object.drive" && !Object.keys(row.value ?? {}).length) continue;
    gone.delete(row.key);
    const signature = signatureOf(row, slides);
    const known = lines.get(row.key);
    if (known?.signature === signature) {
      known.row = row;
      known.field.update(row.value);
      continue;
    }
    const line = lineOf(row, slides, signature);
    if (known) known.element.replaceWith(line.element);
    else groupNamed(groupOf(row.key, kind)).append(line.element);
    lines.set(row.key, line);
  }
  for (const key of gone) {
    lines.get(key)?.element.remove();
    lines.delete(key);
  }
  option.hidden = false;
});

let scripts = "";
/** Shows the scripts of the selected object, each with a link that opens it. */
function listScripts() {
  const all = scene.objects.get(selected())?.scripts ?? [];
  if (JSON.stringify(all) === scripts) return;
  scripts = JSON.stringify(all);
  groups.get("Script")?.querySelectorAll(".script").forEach((e) => e.remove());
  for (const script of all) {
    const row = make("div", { className: "row script" });
    const open = make("button", { type: "button", className: "link", textContent: `Open ${script.name}` });
    open.onclick = () => openScript(script);
    row.append(make("span", { className: "head", textContent: `${script.kind}, ${script.language}` }), open);
    groupNamed("Script").append(row);
  }
}

function clear() {
  lines.clear();
  groups.clear();
  rows.replaceChildren();
  scripts = "";
  listScripts();
}

// The button that opens the window of a camera or graph.
const larger = make("button", { type: "button", className: "larger", textContent: "In a window", hidden: true });
larger.prepend(icon("windows"));
larger.onclick = () => {
  const window = windowOf(selected());
  if (window) toggle(window.kind, window.spec);
};
what.after(larger);

function title() {
  const o = scene.objects.get(selected());
  larger.hidden = !windowOf(selected());
  what.textContent = o ? `${o.alias} \u2014 ${o.sensor ?? o.kind}` : "Nothing is selected";
}

watch("selected", (id) => {
  const o = scene.objects.get(id);
  title();
  clear();
  option.hidden = true;
  get("eye", HTMLCanvasElement).hidden = o?.schema !== "image";
  get("plot", HTMLCanvasElement).hidden = o?.kind !== "graph";
  shown = 0;
  if (o) send({ type: "details", object: id });
});
for (const news of /** @type {const} */ (["scene", "objects"])) {
  watch(news, () => {
    title();
    listScripts();
  });
}
setInterval(() => { if (selected() && !document.hidden) send({ type: "details", object: selected() }); }, OFTEN);
