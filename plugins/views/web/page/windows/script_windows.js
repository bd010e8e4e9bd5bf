// @ts-check
// Shows the windows that scripts open, and sends user actions to the scripts.

import { get } from "tatu/lib/dom";
import { movable } from "tatu/lib/floating_window";
import { t } from "tatu/lib/language";
import { call, on } from "tatu/net/connection";
import { reportError } from "tatu/scene/messages";
import { rights, selection, watch } from "tatu/scene/store";
import { build, refresh } from "tatu/windows/script_widgets";

/** @import { WidgetWindow } from "tatu/windows/script_widgets" */
/**
 * A window: the description that the script sent, and its elements.
 * @typedef {WidgetWindow & { window: number, act: string, box: HTMLElement, title: HTMLElement }} ScriptWindow
 */

const host = get("view");
/** @type {Map<string, ScriptWindow>} */
const openWindows = new Map();

/**
 * Reports a user action to the script.
 * @param {ScriptWindow} window
 * @param {number} n index of the widget
 * @param {string} what the action
 * @param {unknown} [value]
 */
async function reportAction(window, n, what, value) {
  if (!rights.canControl) return;
  try {
    await call(window.act, window.window, n, what, ...(value === undefined ? [] : [value]));
  } catch (e) {
    reportError(e);
  }
}

/**
 * Updates the title, visibility, size and position of a window from its current values.
 * @param {ScriptWindow} window
 */
function updateWindow({ box, title, widgets }) {
  const values = widgets[0]?.values ?? {};
  title.textContent = values.title ?? "";
  // A window that belongs to an object is shown while the object is selected.
  box.hidden = values.visible === false || (Number.isInteger(values.for) && !selection().includes(values.for));
  box.inert = values.enabled === false || !rights.canControl;
  box.setAttribute("aria-label", values.title || t`Window of a script`);
  if (values.width > 0) box.style.width = `${values.width}px`;
  if (values.height > 0) box.style.height = `${values.height}px`;
  if (Number.isFinite(values.x)) box.style.left = `${values.x}px`;
  if (Number.isFinite(values.y)) box.style.top = `${values.y}px`;
}

/**
 * Opens a window, or replaces the one with the same key.
 * @param {string} key
 * @param {any} payload of the event that reports the window
 */
function showWindow(key, payload) {
  const previousBox = openWindows.get(key)?.box;
  const box = document.createElement("section");
  box.className = "window";
  box.style.left = previousBox?.style.left ?? `${16 + 24 * (openWindows.size % 8)}px`;
  box.style.top = previousBox?.style.top ?? `${16 + 24 * (openWindows.size % 8)}px`;
  previousBox?.remove();
  const bar = document.createElement("div");
  bar.className = "title";
  const title = document.createElement("span");
  bar.append(title);
  /** @type {ScriptWindow} */
  const window = { ...payload, box, title, elements: [], report: (n, what, value) => reportAction(window, n, what, value) };
  if (payload.widgets[0].values.closeable) {
    const close = document.createElement("button");
    close.textContent = "\u00D7";
    close.setAttribute("aria-label", t`Close this window`);
    close.onclick = () => reportAction(window, 0, "close");
    bar.append(close);
  }
  box.append(bar, build(window));
  movable(box, bar);
  openWindows.set(key, window);
  updateWindow(window);
  host.append(box);
}

/** The widgets to draw in the next frame, by window: a script may change them more often than the page is drawn. @type {Map<ScriptWindow, Set<number>>} */
const changed = new Map();

/**
 * Draws a widget again in the next frame.
 * @param {ScriptWindow} window
 * @param {number} n index of the widget
 */
function refreshSoon(window, n) {
  if (changed.size === 0) {
    requestAnimationFrame(() => {
      for (const [each, widgets] of changed) for (const k of widgets) refresh(each, k);
      changed.clear();
    });
  }
  changed.set(window, (changed.get(window) ?? new Set()).add(n));
}

function closeAll() {
  for (const { box } of openWindows.values()) box.remove();
  openWindows.clear();
}

watch("selected", () => { for (const window of openWindows.values()) updateWindow(window); });
// After a reconnection, the program sends all windows that still exist.
on("again", closeAll);
on("event", ({ name, payload }) => {
  if (name === "stopped") closeAll();
  if (name !== "ui.window") return;
  const key = `${payload.act} ${payload.window}`;
  if (payload.widgets) {
    showWindow(key, payload);
    return;
  }
  const window = openWindows.get(key);
  if (!window) return;
  if (payload.closed) {
    window.box.remove();
    openWindows.delete(key);
    return;
  }
  const widget = window.widgets[payload.n];
  if (!widget) return;
  Object.assign(widget.values, payload.set);
  if (payload.n === 0) updateWindow(window);
  else refreshSoon(window, payload.n);
});
