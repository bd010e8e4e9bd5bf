// @ts-check
// Keeps texts of scripts that have not been saved when their scene is closed by something else than the user of this
// page: another page, a client, a recovery or a crash. They are stored in the browser, and offered again when the script
// is opened.

import { on } from "tatu/net/connection";
import { scene } from "tatu/scene/store";
import { pathOf } from "tatu/scene/hierarchy";

/** @import { Script } from "tatu/protocol" */

/**
 * Returns what identifies a script in a scene: the path of its object and its kind. Handles and names may change.
 * Returns "" if the scene does not contain the script.
 * @param {number} id the handle of the script
 */
export function placeOf(id) {
  const ofScene = scene.scripts.find((s) => s.id === id);
  if (ofScene) return ` ${ofScene.kind}`;
  for (const o of scene.objects.values()) {
    const found = o.scripts?.find((s) => s.id === id);
    if (found) return `${pathOf(o.id)} ${found.kind}`;
  }
  return "";
}

/**
 * Returns the script at a place, or undefined.
 * @param {string} place
 * @returns {Script | undefined}
 */
export function scriptAt(place) {
  const all = [...scene.scripts, ...[...scene.objects.values()].flatMap((o) => o.scripts ?? [])];
  return place ? all.find((s) => placeOf(s.id) === place) : undefined;
}

/** The working folder of the program. */
let workingFolder = "";
on("hello", ({ folder }) => { workingFolder = folder ?? ""; });

/** Returns a path as an absolute one with slashes: a scene may be opened by a relative or by an absolute path. @param {string} file */
function absolutePath(file) {
  const path = file.replaceAll("\\", "/").replace(/^(\.\/)+/, "");
  return /^(\/|\w:\/)/.test(path) ? path : `${workingFolder.replaceAll("\\", "/")}/${path}`;
}

/**
 * Returns whether two paths are those of the same scene. Scenes in different folders may have files of the same name.
 * @param {string} one
 * @param {string} other
 */
export const isSameScene = (one, other) => absolutePath(one) === absolutePath(other);

/** @param {string} file @param {string} place */
const keyOf = (file, place) => `tatu draft ${JSON.stringify([absolutePath(file), place])}`;

/**
 * Stores the unsaved text of a script.
 * @param {string} file the file of its scene
 * @param {string} place
 * @param {string} text
 */
export function storeDraft(file, place, text) {
  localStorage.setItem(keyOf(file, place), JSON.stringify({ text, time: Date.now() }));
}

/**
 * Returns the unsaved text of a script and the time at which it was stored, ms, or null if there is none.
 * @param {string} file
 * @param {string} place
 * @returns {{ text: string, time: number } | null}
 */
export function draftOf(file, place) {
  const stored = localStorage.getItem(keyOf(file, place));
  return stored === null ? null : JSON.parse(stored);
}

/** @param {string} file @param {string} place */
export function removeDraft(file, place) {
  localStorage.removeItem(keyOf(file, place));
}
