// @ts-check
// The windows that a person has opened over the view: cameras, plots, lists. Each scene opens again with its own.

import { on } from "tatu/net";
import { scene, watch } from "tatu/store";

/**
 * A window: its kind, what it shows, and how it is closed. Within `spec`, objects are paths, which last longer than
 * their handles.
 * @typedef {{ kind: string, spec: unknown, close: () => void }} Pane
 */
/** Opens a window, null: what it would show is not there. @typedef {(spec: any) => Pane | null} Opener */

/** @type {Map<string, { opener: Opener, identity: (spec: any) => string }>} */
const openers = new Map();
/** @type {Set<Pane>} */
const open = new Set();
/** Whether windows open or close by themselves, so that the scene's list stays as it is. */
let quiet = false;

/**
 * Offers a kind of window. Two with the same `identity` are one.
 * @param {string} kind
 * @param {Opener} opener
 * @param {(spec: any) => string} [identity]
 */
export function offer(kind, opener, identity = JSON.stringify) {
  openers.set(kind, { opener, identity });
}

/**
 * @param {string} kind
 * @param {unknown} spec
 */
function find(kind, spec) {
  const identity = openers.get(kind)?.identity ?? JSON.stringify;
  return [...open].find((p) => p.kind === kind && identity(p.spec) === identity(spec));
}

/** @returns {string} */
function key() {
  return `tatu panes ${scene.file}`;
}

/** Remembers what is open in this scene. */
export function remember() {
  if (quiet || !scene.file) return;
  const list = [...open].map(({ kind, spec }) => ({ kind, spec }));
  if (list.length) localStorage.setItem(key(), JSON.stringify(list));
  else localStorage.removeItem(key());
}

/**
 * Opens a window, or brings back the one that shows the same.
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
 * @param {string} kind
 * @param {unknown} spec
 */
export function isOpen(kind, spec) {
  return find(kind, spec) !== undefined;
}

/**
 * Opens what is closed, closes what is open.
 * @param {string} kind
 * @param {unknown} spec
 */
export function toggle(kind, spec) {
  const known = find(kind, spec);
  if (known) known.close();
  else openPane(kind, spec);
}

/**
 * To be called by a window that was closed.
 * @param {Pane} pane
 */
export function gone(pane) {
  open.delete(pane);
  remember();
}

/** Opens the windows that this scene had last. */
function restore() {
  quiet = true;
  for (const pane of [...open]) pane.close();
  try {
    const list = JSON.parse(localStorage.getItem(key()) ?? "[]");
    if (Array.isArray(list)) for (const { kind, spec } of list) openPane(kind, spec);
  } catch {
    // What another version of the page has kept is forgotten.
    localStorage.removeItem(key());
  }
  quiet = false;
}

// Another program may have other handles.
let again = false;
on("again", ({ restarted }) => { again = restarted; });
watch("scene", () => {
  if (scene.another || again) restore();
  again = false;
});
