// @ts-check
// The state of the page: the scene, and the selection.

import { get } from "tatu/dom";
import { on } from "tatu/net";
import { want } from "tatu/wants";

/** @import { SceneObject, Script } from "tatu/protocol" */
/**
 * The scene; `another` is set if it is not the scene that was shown before.
 * @typedef {{ file: string, opened: number, another: boolean, dt: number, objects: Map<number, SceneObject>, scripts: Script[] }} Scene
 */

/**
 * The scene as it was sent, and its objects by handle.
 * @type {Scene}
 */
export const scene = { file: "", opened: -1, another: true, dt: 0.05, objects: new Map(), scripts: [] };
/** Whether this page has control rights. */
export const rights = { acts: true };

/**
 * The events that can be watched, and their arguments: a new scene; objects with changes other than motion; the object
 that * was selected last, 0: none.
 * @typedef {{ scene: Scene, objects: SceneObject[], selected: number }} Watched
 */
/** @type {{ [K in keyof Watched]: ((value: Watched[K]) => void)[] }} */
const watchers = { scene: [], objects: [], selected: [] };
/** The selected objects, the last one last. @type {number[]} */
let chosen = [];

/**
 * Calls `f` when the scene, objects or the selection change.
 * @template {keyof Watched} K
 * @param {K} what
 * @param {(value: Watched[K]) => void} f
 */
export function watch(what, f) {
  watchers[what].push(f);
}

/** The handle of the object that was selected last; 0: none. */
export function selected() {
  return chosen.at(-1) ?? 0;
}

/** The handles of all selected objects. */
export function selection() {
  return [...chosen];
}

/**
 * Selects an object; 0: none. With `add`, it is added to the selection, or removed if it is already selected.
 * @param {number} id
 * @param {boolean} [add]
 */
export function select(id, add = false) {
  if (!add) selectAll(id ? [id] : []);
  else selectAll(chosen.includes(id) ? chosen.filter((other) => other !== id) : [...chosen, id]);
}

/**
 * Returns an object and all objects below it, parents first.
 * @param {number} id
 */
export function under(id) {
  /** @type {Map<number, number[]>} */
  const below = new Map();
  for (const o of scene.objects.values()) below.set(o.parent, [...(below.get(o.parent) ?? []), o.id]);
  /** @type {number[]} */
  const all = [];
  const add = (/** @type {number} */ one) => {
    all.push(one);
    below.get(one)?.forEach(add);
  };
  add(id);
  return all;
}

/**
 * Returns the path of an object, made of aliases, or "" if the object does not exist.
 * @param {number} id
 */
export function pathOf(id) {
  let path = "";
  for (let up = scene.objects.get(id); up; up = scene.objects.get(up.parent)) path = `/${up.alias}${path}`;
  return path;
}

/**
 * Returns the first object at a path of aliases; 0: none.
 * @param {string} path
 */
export function objectAt(path) {
  if (!path) return 0;
  for (const id of scene.objects.keys()) if (pathOf(id) === path) return id;
  return 0;
}

/** @type {number[]} */
let wanted = [];

/**
 * Selects objects.
 * @param {number[]} ids
 */
export function selectAll(ids) {
  wanted = [];
  const all = [...new Set(ids)];
  if (all.join() === chosen.join()) return;
  const before = selected();
  chosen = all;
  for (const f of watchers.selected) f(selected());
  if (selected() !== before) request();
}

/**
 * Selects new objects as soon as the scene contains them.
 * @param {number[]} ids
 */
export function selectWhenThere(ids) {
  wanted = ids;
  choose();
}

function choose() {
  if (wanted.length && wanted.every((id) => scene.objects.has(id))) selectAll(wanted);
}

/** Requests the image or the streams of the selected object. */
function request() {
  const id = selected();
  const o = scene.objects.get(id);
  want("images", "selected", o?.schema === "image" ? id : 0);
  want("graphs", "selected", o?.kind === "graph" ? id : 0);
}

function name() {
  get("name").textContent = scene.file.split(/[\\/]/).pop() || "no scene";
}

on("scene", ({ file, opened, dt, objects, scripts }) => {
  Object.assign(scene, { file, another: file !== scene.file || opened !== scene.opened, opened, dt, scripts, objects: new Map(objects.map((o) => [o.id, o])) });
  name();
  for (const f of watchers.scene) f(scene);
  const left = chosen.filter((id) => scene.objects.has(id));
  if (left.length < chosen.length) selectAll(left);
  choose();
});
on("objects", ({ objects }) => {
  const known = objects.filter((o) => scene.objects.has(o.id));
  for (const o of known) scene.objects.set(o.id, o);
  for (const f of watchers.objects) f(known);
});
// A scene that was saved under another name still counts as the same scene.
on("state", ({ file }) => {
  if (file === scene.file) return;
  scene.file = file;
  name();
});
on("hello", ({ acts }) => {
  rights.acts = acts;
});
