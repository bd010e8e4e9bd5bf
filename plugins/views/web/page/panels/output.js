// @ts-check
// The status line. It expands to the output panel, which has a tab for the status and one for each console of scripts.

import { get, make } from "tatu/lib/dom";
import { icon } from "tatu/lib/icons";
import { on } from "tatu/net/connection";
import { objectAt } from "tatu/scene/hierarchy";
import { line, tell, watchLines } from "tatu/scene/messages";
import { scene, select, watch } from "tatu/scene/store";

/** Maximum number of lines per tab. */
const MOST = 1000;
const tabs = get("tabs");
const output = get("output");
/** @type {Map<string, HTMLElement[]>} */
const pages = new Map();
let open = "Status";
const footer = get("footer");
const more = get("more-output");
const last = get("last-line");
const OPEN = "tatu output";

/** Expands or collapses the output panel. @param {boolean} is */
function unfold(is) {
  footer.classList.toggle("open", is);
  more.setAttribute("aria-expanded", String(is));
  more.replaceChildren(icon(is ? "down" : "up"));
  localStorage.setItem(OPEN, is ? "1" : "");
  output.scrollTop = output.scrollHeight;
}
more.onclick = () => unfold(!footer.classList.contains("open"));
last.onclick = () => unfold(true);

/** Shows the newest line of the open tab in the status line. */
function lastLine() {
  const newest = page(open).at(-1);
  last.textContent = newest?.textContent ?? "";
  last.className = newest?.className ?? "";
}

/** Returns the lines of a tab, and creates the tab if necessary. @param {string} name */
function page(name) {
  const known = pages.get(name);
  if (known) return known;
  /** @type {HTMLElement[]} */
  const lines = [];
  pages.set(name, lines);
  const b = make("button", { textContent: name, onclick: () => { show(name); unfold(true); } });
  b.setAttribute("role", "tab");
  tabs.append(b);
  mark();
  return lines;
}

function mark() {
  for (const b of tabs.children) {
    b.setAttribute("aria-selected", String(b.textContent === open));
    b.classList.toggle("on", b.textContent === open);
  }
}

/** Opens a tab. @param {string} name */
function show(name) {
  open = name;
  mark();
  output.replaceChildren(...page(name));
  output.scrollTop = output.scrollHeight;
  lastLine();
}

/** Removes the lines of all tabs. */
export function clear() {
  for (const name of pages.keys()) pages.set(name, []);
  show(open);
}

/**
 * Replaces object names in a warning or error by links that select the objects: a path at the beginning, or names in
 * parentheses at the end, as in notes of importers.
 * @param {HTMLElement} div
 */
function linkObjects(div) {
  const text = div.textContent ?? "";
  if (!/warning|error/.test(div.className) || div.querySelector("button")) return;
  const link = (/** @type {string} */ name, /** @type {number} */ id) => make("button", { type: "button", textContent: name, onclick: () => select(id) });
  const path = objectAt(text.match(/^`?(\/[^\s`:]+)/)?.[1] ?? "");
  if (path) {
    div.replaceChildren(link(text, path));
    return;
  }
  const [, before = "", names = ""] = text.match(/^(.*\()([^()]+)\)$/s) ?? [];
  const parts = names.split(", ").map((name) => {
    const found = [...scene.objects.values()].find((o) => o.alias === name);
    return found ? link(name, found.id) : name;
  });
  if (!parts.some((part) => typeof part !== "string")) return;
  div.replaceChildren(before, ...parts.flatMap((part, i) => (i ? [", ", part] : [part])), ")");
}
let noted = "";
// Notes from loading a scene are shown once per scene.
on("scene", ({ file, notes }) => {
  const key = JSON.stringify([file, notes]);
  if (key !== noted) for (const note of notes ?? []) line("Status", note, "warning");
  noted = key;
});
// Lines that were written before the scene arrived get their links now.
watch("scene", () => {
  for (const lines of pages.values()) lines.forEach(linkObjects);
  lastLine();
});

watchLines(({ tab, text, level }) => {
  const div = make("div", { className: level, textContent: text });
  linkObjects(div);
  const all = page(tab);
  all.push(div);
  const bottom = output.scrollTop + output.clientHeight >= output.scrollHeight - 8;
  if (all.length > MOST) all.shift()?.remove();
  if (tab === open) {
    output.append(div);
    if (bottom) output.scrollTop = output.scrollHeight;
    lastLine();
  }
});

on("event", ({ name, payload }) => {
  if (name === "message") line("Status", payload.text, payload.level);
  else if (name === "console") {
    if (payload.clear) pages.set(payload.title, []);
    else line(payload.title, payload.text);
    if (open === payload.title) show(open);
  }
  else if (name === "started") line("Status", "simulation started");
  else if (name === "stopped") line("Status", "simulation stopped: the scene was reset");
});
on("again", clear);
on("error", tell);
page("Status");
unfold(localStorage.getItem(OPEN) === "1");
