// @ts-check
// The windows that the user has opened over the view, such as images of cameras and plots. They are stored in the
// browser for each scene, and opened again with it.

import { on } from "tatu/net/connection";
import { scene, watch } from "tatu/scene/store";

/**
 * A window: its kind, a description of its content, and a function that closes it. In `spec`, objects are identified by
 * paths, because handles change between runs of the program.
 * @typedef {{ kind: string, spec: unknown, close: () => void }} Pane
 */
/** @typedef {(spec: any) => Pane | null} Opener opens a window, or returns null if its content does not exist */

/** @type {Map<string, { opener: Opener, identity: (spec: any) => string }>} */
const openers = new Map();
/** @type {Set<Pane>} */
const open = new Set();
/** Whether windows are being opened or closed automatically, which must not change the list stored for the scene. */
let quiet = false;

/**
 * Registers a kind of window. Only one window with the same `identity` can be open.
 * @param {string} kind
 * @param {Opener} opener
 * @param {(spec: any) => string} [identity]
 */
export function offer(kind, opener, identity = JSON.stringify) {
  openers.set(kind, { opener, identity });
}

/**
 * Returns the open window with a kind and description, or undefined.
 * @param {string} kind
 * @param {unknown} spec
 */
function find(kind, spec) {
  const identity = openers.get(kind)?.identity ?? JSON.stringify;
  return [...open].find((p) => p.kind === kind && identity(p.spec) === identity(spec));
}

/** Returns the key under which the windows of this scene are stored. @returns {string} */
function key() {
  return `tatu panes ${scene.file}`;
}

/** Stores the windows that are open in this scene. */
export function remember() {
  if (quiet || !scene.file) return;
  const list = [...open].map(({ kind, spec }) => ({ kind, spec }));
  if (list.length) localStorage.setItem(key(), JSON.stringify(list));
  else localStorage.removeItem(key());
}

/**
 * Opens a window, unless it is already open.
 * @param {string} kind
 * @param {unknown} spec
 */
export function openPane(kind, spec) {
  if (isOpen(kind, spec)) return;
  const pane = openers.get(kind)?.opener(spec);
  if (!pane) return;
  open.add(pane);
  remember();
}

/**
 * Returns whether a window is open.
 * @param {string} kind
 * @param {unknown} spec
 */
export function isOpen(kind, spec) {
  return find(kind, spec) !== undefined;
}

/**
 * Opens a window, or closes it if it is open.
 * @param {string} kind
 * @param {unknown} spec
 */
export function toggle(kind, spec) {
  const known = find(kind, spec);
  if (known) known.close();
  else openPane(kind, spec);
}

/**
 * Removes a window from the open ones. Each window must call this function when it is closed.
 * @param {Pane} pane
 */
export function gone(pane) {
  open.delete(pane);
  remember();
}

/** Closes all windows, and opens those that are stored for this scene. */
function restore() {
  quiet = true;
  for (const pane of [...open]) pane.close();
  try {
    const list = JSON.parse(localStorage.getItem(key()) ?? "[]");
    if (Array.isArray(list)) for (const { kind, spec } of list) openPane(kind, spec);
  } catch {
    // Entries stored by a different version of the page are dropped.
    localStorage.removeItem(key());
  }
  quiet = false;
}

// A restarted program may use different handles, so windows must be opened again.
let again = false;
on("again", ({ restarted }) => { again = restarted; });
watch("scene", () => {
  if (scene.another || again) restore();
  again = false;
});
