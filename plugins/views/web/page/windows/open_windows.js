// @ts-check
// The windows that the user has opened over the view, such as images of cameras and plots. They are stored in the
// browser for each scene, and opened again with it.

import { on } from "tatu/net/connection";
import { scene, watch } from "tatu/scene/store";

/**
 * A window: its kind, a description of its content, and a function that closes it. In `spec`, objects are identified by
 * paths, because handles change between runs of the program.
 * @typedef {{ kind: string, spec: unknown, close: () => void }} OpenWindow
 */
/** @typedef {(spec: any) => OpenWindow | null} Opener opens a window, or returns null if its content does not exist */

/** @type {Map<string, { opener: Opener, identity: (spec: any) => string }>} */
const openers = new Map();
/** @type {Set<OpenWindow>} */
const openWindows = new Set();
/** Whether windows are being opened or closed automatically, which must not change the list stored for the scene. */
let isRestoring = false;

/**
 * Registers a kind of window. Only one window with the same `identity` can be open.
 * @param {string} kind
 * @param {Opener} opener
 * @param {(spec: any) => string} [identity]
 */
export function registerWindow(kind, opener, identity = JSON.stringify) {
  openers.set(kind, { opener, identity });
}

/**
 * Returns the open window with a kind and description, or undefined.
 * @param {string} kind
 * @param {unknown} spec
 */
function findOpen(kind, spec) {
  const identity = openers.get(kind)?.identity ?? JSON.stringify;
  return [...openWindows].find((p) => p.kind === kind && identity(p.spec) === identity(spec));
}

/** Returns the key under which the windows of this scene are stored. @returns {string} */
function storageKey() {
  return `tatu panes ${scene.file}`;
}

/** Stores the windows that are open in this scene. */
export function storeWindows() {
  if (isRestoring || !scene.file) return;
  localStorage.setItem(storageKey(), JSON.stringify([...openWindows].map(({ kind, spec }) => ({ kind, spec }))));
}

/**
 * Returns the windows that are stored for this scene, or null if the user has neither opened nor closed any.
 * @returns {{ kind: string, spec: unknown }[] | null}
 */
function storedWindows() {
  try {
    const list = JSON.parse(localStorage.getItem(storageKey()) ?? "null");
    return Array.isArray(list) ? list : null;
  } catch {
    return null;
  }
}

/** Returns whether the user has chosen the windows of this scene. The window of an exercise opens by itself. */
export function hasLayout() {
  const list = storedWindows();
  return list !== null && (list.length === 0 || list.some(({ kind }) => kind !== "exercise"));
}

/**
 * Opens a window, unless it is already open.
 * @param {string} kind
 * @param {unknown} spec
 */
export function openWindow(kind, spec) {
  if (isWindowOpen(kind, spec)) return;
  const opened = openers.get(kind)?.opener(spec);
  if (!opened) return;
  openWindows.add(opened);
  storeWindows();
}

/**
 * Returns whether a window is open.
 * @param {string} kind
 * @param {unknown} spec
 */
export function isWindowOpen(kind, spec) {
  return findOpen(kind, spec) !== undefined;
}

/**
 * Opens a window, or closes it if it is open.
 * @param {string} kind
 * @param {unknown} spec
 */
export function toggleWindow(kind, spec) {
  const existing = findOpen(kind, spec);
  if (existing) existing.close();
  else openWindow(kind, spec);
}

/**
 * Removes a window from the open ones. Each window must call this function when it is closed.
 * @param {OpenWindow} opened
 */
export function windowClosed(opened) {
  openWindows.delete(opened);
  storeWindows();
}

/** Closes all windows, and opens those that are stored for this scene. */
function restore() {
  isRestoring = true;
  for (const opened of [...openWindows]) opened.close();
  try {
    for (const { kind, spec } of storedWindows() ?? []) openWindow(kind, spec);
  } catch {
    // Entries stored by a different version of the page are dropped.
    localStorage.removeItem(storageKey());
  }
  isRestoring = false;
}

// A restarted program may use different handles, so windows must be opened again.
let isRestarted = false;
on("again", ({ restarted }) => { isRestarted = restarted; });
watch("scene", () => {
  if (scene.isNew || isRestarted) restore();
  isRestarted = false;
});
