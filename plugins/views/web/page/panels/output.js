// @ts-check
// The status line. It expands to the output panel, which has a tab for the status and one for each console of scripts.

import { get, make } from "tatu/lib/dom";
import { icon } from "tatu/lib/icons";
import { mark, t, translate } from "tatu/lib/language";
import { on } from "tatu/net/connection";
import { objectAt } from "tatu/scene/hierarchy";
import { reportError, watchLines, writeLine } from "tatu/scene/messages";
import { scene, select, watch } from "tatu/scene/store";

/** Maximum number of lines per tab. */
const MAX_LINES = 1000;
const tabs = get("tabs");
const output = get("output");
/** @type {Map<string, HTMLElement[]>} */
const linesByTab = new Map();
let open = mark("Status");
const footer = get("footer");
const expandButton = get("more-output");
const statusLine = get("last-line");
const OPEN_KEY = "tatu output";

/** Expands or collapses the output panel. @param {boolean} isExpanded */
function setExpanded(isExpanded) {
  footer.classList.toggle("open", isExpanded);
  expandButton.setAttribute("aria-expanded", String(isExpanded));
  expandButton.replaceChildren(icon(isExpanded ? "down" : "up"));
  localStorage.setItem(OPEN_KEY, isExpanded ? "1" : "");
  output.scrollTop = output.scrollHeight;
}
expandButton.onclick = () => setExpanded(!footer.classList.contains("open"));
statusLine.onclick = () => setExpanded(true);

/** Shows the newest line of the open tab in the status line. */
function lastLine() {
  const newest = linesOf(open).at(-1);
  statusLine.textContent = newest?.textContent ?? "";
  statusLine.className = newest?.className ?? "";
}

/** Numbers of warnings and errors in the status tab. */
const counts = { warning: 0, error: 0 };
/** Shows the numbers of warnings and errors, if there are any. */
function showCounts() {
  const texts = { warning: counts.warning === 1 ? t`1 warning` : t`${counts.warning} warnings`, error: counts.error === 1 ? t`1 error` : t`${counts.error} errors` };
  for (const level of /** @type {const} */ (["warning", "error"])) {
    const badge = get(`${level}-count`);
    badge.hidden = counts[level] === 0;
    badge.textContent = String(counts[level]);
    badge.title = texts[level];
    badge.setAttribute("aria-label", texts[level]);
    badge.onclick = () => {
      showTab(mark("Status"));
      setExpanded(true);
      [...output.querySelectorAll(`.${level}`)].at(-1)?.scrollIntoView({ block: "nearest" });
    };
  }
}

/** Returns the lines of a tab, and creates the tab if necessary. @param {string} name */
function linesOf(name) {
  const existing = linesByTab.get(name);
  if (existing) return existing;
  /** @type {HTMLElement[]} */
  const lines = [];
  linesByTab.set(name, lines);
  const b = make("button", { textContent: translate(name), onclick: () => { showTab(name); setExpanded(true); } });
  b.setAttribute("role", "tab");
  b.dataset.tab = name;
  tabs.append(b);
  markTab();
  return lines;
}

function markTab() {
  for (const b of tabs.querySelectorAll("button")) {
    b.setAttribute("aria-selected", String(b.dataset.tab === open));
    b.classList.toggle("on", b.dataset.tab === open);
  }
}

/** Opens a tab. @param {string} name */
function showTab(name) {
  open = name;
  markTab();
  output.replaceChildren(...linesOf(name));
  output.scrollTop = output.scrollHeight;
  lastLine();
}

/** Removes the lines of all tabs. */
export function clear() {
  for (const name of linesByTab.keys()) linesByTab.set(name, []);
  counts.warning = counts.error = 0;
  showCounts();
  showTab(open);
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
let shownNotes = "";
// Notes from loading a scene are shown once per scene.
on("scene", ({ file, notes }) => {
  const key = JSON.stringify([file, notes]);
  if (key !== shownNotes) for (const note of notes ?? []) writeLine("Status", note, "warning");
  shownNotes = key;
});
// Lines that were written before the scene arrived get their links now.
watch("scene", () => {
  if (scene.isNew) {
    counts.warning = counts.error = 0;
    showCounts();
  }
  for (const lines of linesByTab.values()) lines.forEach(linkObjects);
  lastLine();
});

watchLines(({ tab, text, level }) => {
  if (tab === "Status" && (level === "warning" || level === "error")) {
    counts[level]++;
    showCounts();
  }
  const div = make("div", { className: level, textContent: text });
  linkObjects(div);
  const all = linesOf(tab);
  all.push(div);
  const bottom = output.scrollTop + output.clientHeight >= output.scrollHeight - 8;
  if (all.length > MAX_LINES) all.shift()?.remove();
  if (tab === open) {
    output.append(div);
    if (bottom) output.scrollTop = output.scrollHeight;
    lastLine();
  }
});

on("event", ({ name, payload }) => {
  if (name === "message") writeLine("Status", payload.text, payload.level);
  else if (name === "console") {
    if (payload.clear) linesByTab.set(payload.title, []);
    else writeLine(payload.title, payload.text);
    if (open === payload.title) showTab(open);
  }
  else if (name === "started") writeLine("Status", t`simulation started`);
  else if (name === "stopped") writeLine("Status", t`simulation stopped: the scene was reset`);
});
on("again", clear);
on("error", reportError);
linesOf("Status");
setExpanded(localStorage.getItem(OPEN_KEY) === "1");
