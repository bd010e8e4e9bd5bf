// @ts-check
// The status bar, and a tab for each console that scripts open.

import { get, make } from "tatu/dom";
import { on } from "tatu/net";

const MOST = 1000;
const tabs = get("tabs");
const output = get("output");
/** @type {Map<string, HTMLElement[]>} */
const pages = new Map();
let open = "Status";

/** @param {string} name */
function page(name) {
  const known = pages.get(name);
  if (known) return known;
  /** @type {HTMLElement[]} */
  const lines = [];
  pages.set(name, lines);
  const b = make("button", { textContent: name, onclick: () => show(name) });
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

/** @param {string} name */
function show(name) {
  open = name;
  mark();
  output.replaceChildren(...page(name));
  output.scrollTop = output.scrollHeight;
}

/** Empties all pages. */
export function clear() {
  for (const name of pages.keys()) pages.set(name, []);
  show(open);
}

/**
 * Writes a line.
 * @param {string} name
 * @param {string} text
 * @param {string} [level]
 */
export function line(name, text, level = "") {
  const div = make("div", { className: level, textContent: text });
  const all = page(name);
  all.push(div);
  const bottom = output.scrollTop + output.clientHeight >= output.scrollHeight - 8;
  if (all.length > MOST) all.shift()?.remove();
  if (name === open) {
    output.append(div);
    if (bottom) output.scrollTop = output.scrollHeight;
  }
}

on("event", ({ name, payload }) => {
  if (name === "message") line("Status", payload.text, payload.level);
  else if (name === "console") {
    if (payload.clear) pages.set(payload.title, []);
    else line(payload.title, payload.text);
    if (open === payload.title) show(open);
  }
  else if (name === "started") line("Status", "simulation started");
  else if (name === "stopped") line("Status", "simulation stopped: the scene is as it was");
});
on("again", clear);
on("error", ({ error, help }) => line("Status", help ? `${error} (${help})` : error, "error"));
page("Status");
