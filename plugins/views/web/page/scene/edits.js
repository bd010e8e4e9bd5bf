// @ts-check
// Edits of the scene. Each edit has a label and can be undone. All changes that a user makes to the scene must be made
// by this module.

import { call, on } from "tatu/net/connection";
import { scene } from "tatu/scene/store";

/** @import { Messages } from "tatu/net/connection" */
/** @typedef {[string, ...unknown[]]} Call The name of a command and its arguments. */
/** @typedef {Omit<Messages["state"], "type" | "speed" | "dt">} Known */

/**
 * The state of undo, redo and unsaved edits, as last reported by the program.
 * @type {Known}
 */
export const known = { undo: null, redo: null, unsaved: false, file: "", on_disk: false, recovery: null, state: "stopped" };
/** @type {((known: Known) => void)[]} */
const watchers = [];

/**
 * Calls `f` whenever the program reports the state of edits.
 * @param {(known: Known) => void} f
 */
export function watchEdits(f) {
  watchers.push(f);
}

on("state", ({ undo, redo, unsaved, file, on_disk, recovery, state }) => {
  Object.assign(known, { undo, redo, unsaved, file, on_disk, recovery, state });
  for (const f of watchers) f(known);
});

let limits = false;
/**
 * Sets whether users may change only scripts, as in exercises.
 * @param {boolean} scriptsOnly
 */
export function limit(scriptsOnly) {
  limits = scriptsOnly;
  document.body.classList.toggle("limited", limits);
}

/** Returns whether users may change only scripts. */
export function limited() {
  return limits;
}

/**
 * Calls commands as a single edit. Returns a promise of the results of each call. Consecutive edits with the same label
 * and the same nonempty `merge`, such as those of a drag, are undone together.
 * @param {string} label description that can follow the word "Undo", such as "Move box"
 * @param {Call[]} calls
 * @param {string} [merge]
 * @returns {Promise<any[][]>}
 */
export async function edit(label, calls, merge = "") {
  if (limits) throw { error: `"${label}" was refused: in this exercise, only scripts may be changed`, help: "open the script of an object by a double click in the tree" };
  const [results] = await call("tatu.edit", label, calls, merge);
  return results;
}

/** Undoes the last edit. Returns a promise of its label, or of null if there is no edit to undo. */
export async function undo() {
  return (await call("tatu.undo"))[0] ?? null;
}

/** Redoes the edit that was undone last. Returns a promise of its label, or of null if there is no edit to redo. */
export async function redo() {
  return (await call("tatu.redo"))[0] ?? null;
}

/**
 * Returns a description of objects for a label: the name of a single object, or the number of objects.
 * @param {number[]} ids
 */
export function named(ids) {
  const [one] = ids;
  return ids.length === 1 && one !== undefined ? scene.objects.get(one)?.alias ?? "object" : `${ids.length} objects`;
}

let last = 0;
/** Returns a unique value for `merge`. */
export function together() {
  return `${Date.now()} ${++last}`;
}
