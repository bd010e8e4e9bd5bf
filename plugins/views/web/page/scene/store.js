// @ts-check
// The state of the page: the scene, and the selection.

import { get } from "tatu/lib/dom";
import { t } from "tatu/lib/language";
import { on } from "tatu/net/connection";
import { subscribe } from "tatu/net/subscriptions";

/** @import { SceneObject, Script } from "tatu/protocol" */
/**
 * The scene. `objects` contains its objects by handle; `isNew` is set if this is not the scene that was shown before; `about`
 * and `suggestion` are from the comment at the beginning of its file.
 * @typedef {{ file: string, opened: number, isNew: boolean, dt: number, about: string, suggestion: string, objects: Map<number, SceneObject>, scripts: Script[] }} Scene
 */

/**
 * The scene that the program sent last.
 * @type {Scene}
 */
export const scene = { file: "", opened: -1, isNew: true, dt: 0.05, about: "", suggestion: "", objects: new Map(), scripts: [] };
/** The rights of this page: `canControl` is whether it has control rights. */
export const rights = { canControl: true };

/**
 * The events that can be watched, and their arguments: a new scene; objects that have changed in other ways than by
 * moving; a change of the selection, with the object that was selected last or 0.
 * @typedef {{ scene: Scene, objects: SceneObject[], selected: number }} Watched
 */
/** @type {{ [K in keyof Watched]: ((value: Watched[K]) => void)[] }} */
const watchers = { scene: [], objects: [], selected: [] };
/** Handles of the selected objects, in the order of selection. @type {number[]} */
let selectedIds = [];

/**
 * Calls `f` after each event of a kind.
 * @template {keyof Watched} K
 * @param {K} what
 * @param {(value: Watched[K]) => void} f
 */
export function watch(what, f) {
  watchers[what].push(f);
}

/** Returns the handle of the object that was selected last; 0: none. */
export function selected() {
  return selectedIds.at(-1) ?? 0;
}

/** Returns the handles of all selected objects, in the order of selection. */
export function selection() {
  return [...selectedIds];
}

/**
 * Selects an object, or nothing if `id` is 0. If `add` is set, the object is added to the selection instead, or removed
 * from it if it is already selected.
 * @param {number} id
 * @param {boolean} [add]
 */
export function select(id, add = false) {
  if (!add) selectAll(id ? [id] : []);
  else selectAll(selectedIds.includes(id) ? selectedIds.filter((other) => other !== id) : [...selectedIds, id]);
}

/** Objects that will be selected when the scene contains them. @type {number[]} */
let pendingIds = [];

/**
 * Selects these objects instead of the current ones.
 * @param {number[]} ids
 */
export function selectAll(ids) {
  pendingIds = [];
  const all = [...new Set(ids)];
  if (all.join() === selectedIds.join()) return;
  const previous = selected();
  selectedIds = all;
  for (const f of watchers.selected) f(selected());
  if (selected() !== previous) subscribeToSelected();
}

/**
 * Selects new objects as soon as the scene contains them.
 * @param {number[]} ids
 */
export function selectWhenPresent(ids) {
  pendingIds = ids;
  selectPending();
}

/** Selects the wanted objects if the scene contains all of them. */
function selectPending() {
  if (pendingIds.length && pendingIds.every((id) => scene.objects.has(id))) selectAll(pendingIds);
}

/** Functions that wait for objects, by the handle of the object. @type {Map<number, (() => void)[]>} */
const waiting = new Map();

/**
 * Returns a promise that is resolved as soon as the scene contains an object, which may be new.
 * @param {number} id
 * @returns {Promise<void>}
 */
export function whenPresent(id) {
  if (scene.objects.has(id)) return Promise.resolve();
  return new Promise((resolve) => waiting.set(id, [...(waiting.get(id) ?? []), resolve]));
}

/** Resolves the promises of `whenPresent` for objects that the scene contains now. */
function resolveWaiting() {
  for (const [id, all] of waiting) {
    if (!scene.objects.has(id)) continue;
    waiting.delete(id);
    for (const resolve of all) resolve();
  }
}

/** Returns whether the depths of a sensor are shown at first, instead of its colors. @param {SceneObject | undefined} o */
export function showsDepth(o) {
  return o?.depth === true && /depth\d*$/i.test(o.alias);
}

/** Requests the images or streams of the object that was selected last. */
function subscribeToSelected() {
  const id = selected();
  const o = scene.objects.get(id);
  const hasImage = o?.schema === "image";
  subscribe("images", "selected", hasImage && !showsDepth(o) ? id : 0);
  subscribe("depths", "selected", hasImage && showsDepth(o) ? id : 0);
  subscribe("graphs", "selected", o?.kind === "graph" ? id : 0);
}

function showFileName() {
  get("name").textContent = scene.file.split(/[\\/]/).pop() || t`no scene`;
}

on("scene", ({ file, opened, dt, objects, scripts, about, try: suggestion }) => {
  Object.assign(scene, { file, isNew: file !== scene.file || opened !== scene.opened, opened, dt, scripts, about: about ?? "", suggestion: suggestion ?? "", objects: new Map(objects.map((o) => [o.id, o])) });
  showFileName();
  // The handles of another scene are those of other objects.
  if (scene.isNew) {
    selectAll([]);
    waiting.clear();
  }
  for (const f of watchers.scene) f(scene);
  const remaining = selectedIds.filter((id) => scene.objects.has(id));
  if (remaining.length < selectedIds.length) selectAll(remaining);
  selectPending();
  resolveWaiting();
});
on("objects", ({ objects }) => {
  const existing = objects.filter((o) => scene.objects.has(o.id));
  for (const o of existing) scene.objects.set(o.id, o);
  for (const f of watchers.objects) f(existing);
});
// A scene that was saved under another name remains the same scene, so watchers are not called.
on("state", ({ file }) => {
  if (file === scene.file) return;
  scene.file = file;
  showFileName();
});
on("hello", ({ acts }) => {
  rights.canControl = acts;
});
