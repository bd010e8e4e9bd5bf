// @ts-check
// Edits of the scene. Each edit has a label and can be undone. All changes that a user makes to the scene must be made
// by this module.

import { t } from "tatu/lib/language";
import { call, on } from "tatu/net/connection";
import { scene } from "tatu/scene/store";

/** @import { Messages } from "tatu/net/connection" */
/** @typedef {[string, ...unknown[]]} Call The name of a command and its arguments. */
/** @typedef {Omit<Messages["state"], "type" | "speed" | "dt">} EditState */

/**
 * The state of undo, redo and unsaved edits, as last reported by the program.
 * @type {EditState}
 */
export const editState = { undo: null, redo: null, unsaved: false, file: "", on_disk: false, recovery: null, state: "stopped" };
/** @type {((state: EditState) => void)[]} */
const watchers = [];

/**
 * Calls `f` whenever the program reports the state of edits.
 * @param {(state: EditState) => void} f
 */
export function watchEdits(f) {
  watchers.push(f);
}

on("state", ({ undo, redo, unsaved, file, on_disk, recovery, state }) => {
  Object.assign(editState, { undo, redo, unsaved, file, on_disk, recovery, state });
  for (const f of watchers) f(editState);
});

let scriptsOnly = false;
/**
 * Sets whether users may change only scripts, as in exercises.
 * @param {boolean} on
 */
export function setScriptsOnly(on) {
  scriptsOnly = on;
  document.body.classList.toggle("limited", scriptsOnly);
}

/** Returns whether users may change only scripts. */
export function isScriptsOnly() {
  return scriptsOnly;
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
  if (scriptsOnly) throw { error: t`"${label}" was refused: in this exercise, only scripts may be changed`, help: t`open the script of an object by a double click in the tree` };
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
export function describeObjects(ids) {
  const [one] = ids;
  return ids.length === 1 && one !== undefined ? scene.objects.get(one)?.alias ?? t`object` : t`${ids.length} objects`;
}

let last = 0;
/** Returns a unique value for `merge`. */
export function newMergeKey() {
  return `${Date.now()} ${++last}`;
}
