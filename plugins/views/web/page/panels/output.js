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
/** Length at which a line of a console that is not ended by a line feed is continued on the next line, characters. */
const MAX_LINE_LENGTH = 4000;
const tabs = get("tabs");
const output = get("output");
/**
 * A tab: its lines, and the number of characters in the last one if text may be added to it, otherwise -1.
 * @typedef {{ lines: HTMLElement[], unended: number }} Tab
 */
/** @type {Map<string, Tab>} */
const allTabs = new Map();
let open = mark("Status");
const footer = get("footer");
const expandButton = get("more-output");
const statusLine = get("last-line");
const OPEN_KEY = "tatu output";

/** Expands or collapses the output panel. @param {boolean} isExpanded */
function expand(isExpanded) {
  footer.classList.toggle("open", isExpanded);
  expandButton.setAttribute("aria-expanded", String(isExpanded));
  expandButton.replaceChildren(icon(isExpanded ? "down" : "up"));
  output.scrollTop = output.scrollHeight;
}
/** Expands or collapses the output panel as the user has chosen, also when the page is loaded again. @param {boolean} isExpanded */
function setExpanded(isExpanded) {
  localStorage.setItem(OPEN_KEY, isExpanded ? "1" : "");
  expand(isExpanded);
}
expandButton.onclick = () => setExpanded(!footer.classList.contains("open"));
statusLine.onclick = () => {
  showTab(mark("Status"));
  setExpanded(true);
};

/** Shows the newest message in the status line, also while the lines of a console are shown. */
function lastLine() {
  const newest = tabOf(mark("Status")).lines.at(-1);
  statusLine.textContent = newest?.textContent ?? "";
  statusLine.className = newest?.className ?? "";
}

let isScheduled = false;
/**
 * Shows the lines of the open tab in the next frame. Scripts may print thousands of lines in a second, and the browser
 * computes the layout whenever the scroll position is read after a line was added.
 */
function scheduleUpdate() {
  if (isScheduled) return;
  isScheduled = true;
  requestAnimationFrame(update);
}

/** Shows the lines of the open tab, and stays at its end if the end is visible. */
function update() {
  isScheduled = false;
  const { lines } = tabOf(open);
  const isAtEnd = output.scrollTop + output.clientHeight >= output.scrollHeight - 8;
  while (output.firstChild && output.firstChild !== lines[0]) output.firstChild.remove();
  output.append(...lines.slice(output.childElementCount));
  if (isAtEnd) output.scrollTop = output.scrollHeight;
  lastLine();
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

/** Returns a tab, which is created if necessary. @param {string} name */
function tabOf(name) {
  const existing = allTabs.get(name);
  if (existing) return existing;
  /** @type {Tab} */
  const tab = { lines: [], unended: -1 };
  allTabs.set(name, tab);
  const b = make("button", { textContent: translate(name), onclick: () => { showTab(name); setExpanded(true); } });
  b.setAttribute("role", "tab");
  b.dataset.tab = name;
  tabs.append(b);
  markTab();
  return tab;
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
  footer.classList.toggle("with-console", open !== "Status");
  markTab();
  output.replaceChildren(...tabOf(name).lines);
  output.scrollTop = output.scrollHeight;
  lastLine();
}

/** Removes the lines of a tab. @param {Tab} tab */
function clearTab(tab) {
  tab.lines = [];
  tab.unended = -1;
}

/** Removes the lines of all tabs. */
export function clear() {
  for (const tab of allTabs.values()) clearTab(tab);
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
  for (const { lines } of allTabs.values()) lines.forEach(linkObjects);
  lastLine();
});

/**
 * Adds a line to a tab.
 * @param {string} name
 * @param {string} text
 * @param {string} [level] "", "warning" or "error"
 */
function addLine(name, text, level = "") {
  const { lines } = tabOf(name);
  const div = make("div", { className: level, textContent: text });
  linkObjects(div);
  lines.push(div);
  if (lines.length > MAX_LINES) lines.shift();
  if (name === open || name === "Status") scheduleUpdate();
}

watchLines(({ tab, text, level }) => {
  if (tab === "Status" && (level === "warning" || level === "error")) {
    counts[level]++;
    showCounts();
  }
  addLine(tab, text, level);
});

/**
 * Prints text to a console, which continues its last line until a line feed.
 * @param {string} title
 * @param {string} text
 */
function print(title, text) {
  const tab = tabOf(title);
  const pieces = text.split("\n");
  pieces.forEach((piece, i) => {
    const isEnded = i < pieces.length - 1;
    if (tab.unended >= 0 && tab.unended <= MAX_LINE_LENGTH) {
      tab.lines.at(-1)?.append(piece);
      tab.unended += piece.length;
    } else if (piece || isEnded) {
      addLine(title, piece);
      tab.unended = piece.length;
    }
    if (isEnded) tab.unended = -1;
  });
  if (title === open) scheduleUpdate();
}

/** Whether lines are new. Before the first state, the program sends those from before the connection again. */
let isLive = false;
on("hello", () => { isLive = false; });
on("state", () => { isLive = true; });
on("event", ({ name, payload }) => {
  if (name === "message") writeLine("Status", payload.text, payload.level);
  else if (name === "console") {
    const isNew = !allTabs.has(payload.title);
    if (payload.clear) clearTab(tabOf(payload.title));
    else print(payload.title, payload.text);
    if (isNew && isLive) {
      showTab(payload.title);
      expand(true);
    } else if (payload.title === open) scheduleUpdate();
  } else if (name === "started") {
    // A console of the last run was closed at its end.
    for (const tab of allTabs.values()) tab.unended = -1;
    writeLine("Status", t`simulation started`);
  } else if (name === "stopped") writeLine("Status", t`simulation stopped: the scene was reset`);
});
on("again", clear);
on("error", reportError);
tabOf("Status");
expand(localStorage.getItem(OPEN_KEY) === "1");
