// @ts-check
// Edits of the scene: each can be undone, and is named in words. Everything that changes the scene for a person goes
// through here.

import { call, on } from "tatu/net";
import { scene } from "tatu/store";

/** @import { Messages } from "tatu/net" */
/** @typedef {[string, ...unknown[]]} Call The name of a command and its arguments. */
/** @typedef {Omit<Messages["state"], "type" | "speed" | "dt">} Known */

/**
 * What can be undone, and what is in no file, as the program said last.
 * @type {Known}
 */
export const known = { undo: null, redo: null, unsaved: false, file: "", on_disk: false, recovery: null, state: "stopped" };
/** @type {((known: Known) => void)[]} */
const watchers = [];

/**
 * Calls `f` when that changes.
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
 * Lets only scripts be changed, or everything.
 * @param {boolean} scriptsOnly
 */
export function limit(scriptsOnly) {
  limits = scriptsOnly;
  document.body.classList.toggle("limited", limits);
}

/** Whether only scripts may be changed. */
export function limited() {
  return limits;
}

/**
 * Calls commands as one edit; a promise of a list of results for each call. Consecutive edits with the same label and
 * the same `merge`, such as those of a drag, are undone together.
 * @param {string} label what it does, in words that follow "Undo"
 * @param {Call[]} calls
 * @param {string} [merge]
 * @returns {Promise<any[][]>}
 */
export async function edit(label, calls, merge = "") {
  if (limits) throw { error: `"${label}" was not done: this exercise lets only scripts be changed`, help: "open the script of an object by a double click in the tree" };
  const [results] = await call("tatu.edit", label, calls, merge);
  return results;
}

/** Takes the last edit back; a promise of its label, null: there is none. */
export async function undo() {
  return (await call("tatu.undo"))[0] ?? null;
}

/** Repeats what was undone last; a promise of its label, null: there is none. */
export async function redo() {
  return (await call("tatu.redo"))[0] ?? null;
}

/**
 * Objects in words, for a label.
 * @param {number[]} ids
 */
export function named(ids) {
  const [one] = ids;
  return ids.length === 1 && one !== undefined ? scene.objects.get(one)?.alias ?? "object" : `${ids.length} objects`;
}

let last = 0;
/** A text for `merge` that no other edit has. */
export function together() {
  return `${Date.now()} ${++last}`;
}
