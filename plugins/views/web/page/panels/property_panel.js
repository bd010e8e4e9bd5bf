// @ts-check
// The panel with the properties of the selected object: grouped, with names, units and help. Editable properties have
// input fields.

import { get, make } from "tatu/lib/dom";
import { icon } from "tatu/lib/icons";
import { t, translate } from "tatu/lib/language";
import { on, send } from "tatu/net/connection";
import { describeObjects, edit } from "tatu/scene/edits";
import { subtree } from "tatu/scene/hierarchy";
import { GROUPS, TYPE, formOf, groupOf, labelOf, nameOf, unitOf } from "tatu/scene/property_format";
import { rights, scene, selected, watch } from "tatu/scene/store";
import { sizeOf } from "tatu/view/objects";
import { openScript } from "tatu/documents/script_editor";
import { toggleWindow } from "tatu/windows/open_windows";
import { plotRow, plottableCount } from "tatu/windows/plot_window";
import { windowOf } from "tatu/windows/window_menu";
import { fieldOf } from "tatu/panels/property_fields";

/** @import { PropertyRow } from "tatu/protocol" */
/** @import { Field } from "tatu/panels/property_fields" */
/** @typedef {{ element: HTMLElement, signature: string, row: PropertyRow, field: Field, name: HTMLElement }} Line */

const rows = get("rows");
const heading = get("what");
let shownId = 0;
/** The lines of the object's properties, by key. @type {Map<string, Line>} */
const lines = new Map();
/** @type {Map<string, HTMLElement>} */
const groups = new Map();

const rawNames = make("input", { type: "checkbox", checked: localStorage.getItem("tatu raw names") === "1" });
const option = make("label", { className: "raw", title: t`The keys that scripts and scene files use`, hidden: true });
option.append(rawNames, ` ${t`Raw names`}`);
rows.before(option);
rawNames.onchange = () => {
  localStorage.setItem("tatu raw names", rawNames.checked ? "1" : "");
  for (const { name, row } of lines.values()) name.textContent = displayName(row);
};

/** Returns the displayed name of a property. @param {PropertyRow} row */
function displayName(row) {
  return rawNames.checked ? row.key : nameOf(row.key);
}

/**
 * Returns the element of a group, and creates it if necessary. Whether a group is open is remembered.
 * @param {string} name
 */
function groupNamed(name) {
  const existing = groups.get(name);
  if (existing) return existing;
  const key = `tatu details ${name}`;
  const group = make("details", { className: "group-of-rows", open: (localStorage.getItem(key) ?? (name === "More" ? "" : "1")) === "1" });
  group.append(make("summary", { textContent: translate(name) }));
  group.ontoggle = () => localStorage.setItem(key, group.open ? "1" : "");
  group.dataset.group = name;
  groups.set(name, group);
  const rank = (/** @type {string} */ n) => (GROUPS.includes(n) ? GROUPS.indexOf(n) : 0.5);
  const next = [...rows.children].find((e) => e instanceof HTMLElement && rank(e.dataset.group ?? "") > rank(name));
  rows.insertBefore(group, next ?? null);
  return group;
}

/**
 * Sets a property of an object, which can be undone.
 * @param {number} id
 * @param {string} key
 * @param {unknown} value
 * @param {string} [merge]
 */
async function setProperty(id, key, value, merge) {
  await edit(labelOf(key, describeObjects([id])), [["tatu.set", id, key, value]], merge);
  send({ type: "details", object: id });
}

/**
 * Returns a string that encodes everything that determines how a field is built. While it does not change, only the
 * value of the field is updated.
 * @param {PropertyRow} row
 * @param {boolean} isPrismatic
 */
function signatureOf(row, isPrismatic) {
  const form = formOf(row);
  const length = form === "parts" && Array.isArray(row.value) ? row.value.length : 0;
  const isLong = form === "text" && String(row.value).includes("\n");
  return JSON.stringify([form, length, isLong, row.settable && rights.canControl, row.choices, isPrismatic, row.min, row.max]);
}

/**
 * Creates the line of a property.
 * @param {PropertyRow} row
 * @param {boolean} isPrismatic whether the object is a prismatic joint
 * @param {string} signature
 * @returns {Line}
 */
function lineOf(row, isPrismatic, signature) {
  const id = shownId;
  const element = make("div", { className: "row" });
  element.dataset.key = row.key;
  const name = make("span", { className: "name", textContent: displayName(row), title: `${row.text} (${row.key})` });
  const errorText = make("p", { className: "why" });
  errorText.setAttribute("role", "alert");
  const settable = row.settable && rights.canControl;
  const setThis = (/** @type {unknown} */ value, /** @type {string} */ merge = "") => setProperty(id, row.key, value, merge);
  const field = fieldOf({ row, name: nameOf(row.key), unit: unitOf(row.unit, isPrismatic), settable, set: setThis }, (text) => { errorText.textContent = text; });
  const help = make("p", { className: "help", textContent: row.text, hidden: true });
  const helpButton = make("button", { type: "button", className: "ask", textContent: "?", hidden: !row.text });
  helpButton.setAttribute("aria-label", t`What is ${nameOf(row.key)}?`);
  helpButton.setAttribute("aria-expanded", "false");
  helpButton.onclick = () => {
    help.hidden = !help.hidden;
    helpButton.setAttribute("aria-expanded", String(!help.hidden));
  };
  const header = make("span", { className: "head" });
  header.append(name, helpButton);
  if (plottableCount(row)) {
    const plotButton = make("button", { type: "button", className: "ask chart", title: t`Plot (Shift: in a new window)` });
    plotButton.setAttribute("aria-label", t`Plot ${nameOf(row.key)}`);
    plotButton.append(icon("graph"));
    plotButton.onclick = (e) => plotRow(id, row, e.shiftKey);
    header.append(plotButton);
  }
  element.classList.toggle("wide", field.wide);
  element.append(header, field.element, errorText, help);
  return { element, signature, row, field, name };
}

/**
 * Returns whether the base of a model is hidden while other parts of the model are visible.
 * @param {number} id
 */
function isOnlyBaseHidden(id) {
  const o = scene.objects.get(id);
  return o !== undefined && o.model && !o.visible && subtree(id).some((below) => scene.objects.get(below)?.visible && scene.objects.get(below)?.parts?.length);
}

/**
 * Returns a property as the panel shows it; null: not at all.
 * @param {PropertyRow} row
 * @returns {PropertyRow | null}
 */
function shownRow(row) {
  const parts = scene.objects.get(shownId)?.parts ?? [];
  // The drive is omitted for objects that do not have one.
  if (row.key === "object.drive" && !Object.keys(row.value ?? {}).length) return null;
  if (row.key === "shape.size") {
    if (parts.some((p) => p.form === "plane")) return null;
    // The size of a mesh, or of several parts, is not a property that can be set.
    if (parts.length === 1 && parts[0]?.form !== "mesh") return row;
    const size = sizeOf(shownId);
    return size && { ...row, settable: false, value: size, text: t`Size of the bounding box along the axes of the object.` };
  }
  if (row.key === "object.visible" && isOnlyBaseHidden(shownId)) {
    return { ...row, type: TYPE.text, settable: false, value: t`yes, except its base`, text: t`The model is visible. Its base is a hidden body, which only collides.` };
  }
  return row;
}

/** Removes the groups without properties. */
function removeEmptyGroups() {
  for (const [name, group] of groups) {
    if (group.querySelector(".row")) continue;
    group.remove();
    groups.delete(name);
  }
}

on("details", (message) => {
  if (message.object !== selected()) return;
  if (shownId !== message.object) clear();
  shownId = message.object;
  const kind = scene.objects.get(shownId)?.kind ?? "";
  const isPrismatic = message.rows.some((row) => row.key === "joint.type" && row.value === "prismatic");
  const removed = new Set(lines.keys());
  for (const received of message.rows) {
    const row = shownRow(received);
    if (!row) continue;
    removed.delete(row.key);
    const signature = signatureOf(row, isPrismatic);
    const existing = lines.get(row.key);
    if (existing?.signature === signature) {
      existing.row = row;
      existing.field.update(row.value);
      continue;
    }
    const line = lineOf(row, isPrismatic, signature);
    if (existing) existing.element.replaceWith(line.element);
    else groupNamed(groupOf(row.key, kind)).append(line.element);
    lines.set(row.key, line);
  }
  for (const key of removed) {
    lines.get(key)?.element.remove();
    lines.delete(key);
  }
  removeEmptyGroups();
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
    const open = make("button", { type: "button", className: "link", textContent: t`Open ${script.name}` });
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
const windowButton = make("button", { type: "button", className: "larger", textContent: t`In a window`, hidden: true });
windowButton.prepend(icon("windows"));
windowButton.onclick = () => {
  const window = windowOf(selected());
  if (window) toggleWindow(window.kind, window.spec);
};
heading.after(windowButton);

/** Returns the title of a scene: its file name without the extension. @param {string} file */
const titleOf = (file) => (file.split(/[\\/]/).pop() ?? "").replace(/\.\w+$/, "").replaceAll("_", " ");

function showHeading() {
  const o = scene.objects.get(selected());
  windowButton.hidden = !windowOf(selected());
  heading.textContent = o ? `${o.alias} \u2014 ${o.model ? t`model` : translate(o.sensor ?? o.kind)}` : titleOf(scene.file) || t`Nothing is selected`;
}

watch("selected", (id) => {
  const o = scene.objects.get(id);
  showHeading();
  clear();
  option.hidden = true;
  get("eye", HTMLCanvasElement).hidden = o?.schema !== "image";
  get("plot", HTMLCanvasElement).hidden = o?.kind !== "graph";
  shownId = 0;
  follow();
});
for (const change of /** @type {const} */ (["scene", "objects"])) {
  watch(change, () => {
    showHeading();
    listScripts();
  });
}
// The selection may have been made before the scene contained the object.
watch("scene", () => { if (selected()) follow(); });
/** Requests the properties of the selection from now on, unless the page is hidden. */
function follow() {
  const id = selected();
  send({ type: "details", object: scene.objects.has(id) && !document.hidden ? id : 0, follow: true });
}
document.addEventListener("visibilitychange", follow);
// A new connection follows nothing.
on("hello", () => { if (selected()) follow(); });
