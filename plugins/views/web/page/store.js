// @ts-check
// What the page knows: the scene, what is selected, whether anything is in no file yet.

import { get } from "tatu/dom";
import { on, send } from "tatu/net";

/** @import { SceneObject, Script } from "tatu/protocol" */
/** @typedef {{ file: string, dt: number, objects: Map<number, SceneObject>, scripts: Script[] }} Scene */

/**
 * The scene as it was sent, and its objects by handle.
 * @type {Scene}
 */
export const scene = { file: "", dt: 0.05, objects: new Map(), scripts: [] };
/** Whether this page may act. */
export const rights = { acts: true };

/**
 * What can be watched, and what its watchers get: the scene when it is new; objects that have changed otherwise than by
 * moving; the selected object, 0: none.
 * @typedef {{ scene: Scene, objects: SceneObject[], selected: number }} Watched
 */
/** @type {{ [K in keyof Watched]: ((value: Watched[K]) => void)[] }} */
const watchers = { scene: [], objects: [], selected: [] };
let chosen = 0;

/**
 * Calls `f` when the scene, objects or the selection change.
 * @template {keyof Watched} K
 * @param {K} what
 * @param {(value: Watched[K]) => void} f
 */
export function watch(what, f) {
  watchers[what].push(f);
}

/** The handle of the selected object; 0: none. */
export function selected() {
  return chosen;
}

/**
 * Selects an object.
 * @param {number} id
 */
export function select(id) {
  if (id === chosen) return;
  chosen = id;
  for (const f of watchers.selected) f(id);
  request();
}

/** Asks for the image or the streams of the selected object. */
function request() {
  const o = scene.objects.get(chosen);
  send({ type: "image", object: o?.schema === "image" ? chosen : 0 });
  send({ type: "graph", object: o?.kind === "graph" ? chosen : 0 });
}

/** Something was changed that is in no file. */
export function changed(is = true) {
  get("unsaved").hidden = !is;
  sessionStorage.setItem("unsaved", is ? "1" : "");
}

on("scene", ({ file, dt, objects, scripts }) => {
  if (file !== scene.file && scene.file) changed(false);
  Object.assign(scene, { file, dt, scripts, objects: new Map(objects.map((o) => [o.id, o])) });
  get("name").textContent = file.split("/").pop() || "no scene";
  for (const f of watchers.scene) f(scene);
  if (!scene.objects.has(chosen)) select(0);
});
on("objects", ({ objects }) => {
  const known = objects.filter((o) => scene.objects.has(o.id));
  for (const o of known) scene.objects.set(o.id, o);
  for (const f of watchers.objects) f(known);
});
on("hello", ({ acts }) => {
  rights.acts = acts;
  // The program forgets with a connection what was asked for over it.
  if (chosen) request();
});
get("unsaved").hidden = !sessionStorage.getItem("unsaved");
