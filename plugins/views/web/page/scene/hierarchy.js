// @ts-check
// The tree of the scene's objects: which objects are below others, and their paths.

import { scene } from "tatu/scene/store";

/** @import { SceneObject } from "tatu/protocol" */

/**
 * Returns whether the object `id` is below the object `ancestor` in the tree.
 * @param {number} id
 * @param {number} ancestor
 */
export function isBelow(id, ancestor) {
  for (let o = scene.objects.get(id); o; o = scene.objects.get(o.parent)) if (o.parent === ancestor) return true;
  return false;
}

/**
 * Returns the given objects that exist, without those below another of them.
 * @param {number[]} ids
 */
export function topmost(ids) {
  const existing = ids.filter((id) => scene.objects.has(id));
  return existing.filter((id) => !existing.some((other) => isBelow(id, other)));
}

/**
 * Returns an object and all objects below it, parents first.
 * @param {number} id
 */
export function subtree(id) {
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
 * Returns the outermost model that contains an object, or the object itself if there is none.
 * @param {number} id
 */
export function modelOf(id) {
  let found = id;
  for (let o = scene.objects.get(id); o; o = scene.objects.get(o.parent)) if (o.model) found = o.id;
  return found;
}

/**
 * Returns the name of an object in the tree: without the name of its model, with which names of parts often begin.
 * @param {SceneObject} object
 */
export function nameInModel(object) {
  for (let o = scene.objects.get(object.parent); o; o = scene.objects.get(o.parent)) {
    if (!o.model) continue;
    const rest = object.alias.startsWith(`${o.alias}_`) ? object.alias.slice(o.alias.length + 1) : "";
    return rest || object.alias;
  }
  return object.alias;
}

/**
 * Returns the path of an object, which consists of aliases, or "" if the object does not exist.
 * @param {number} id
 */
export function pathOf(id) {
  let path = "";
  for (let up = scene.objects.get(id); up; up = scene.objects.get(up.parent)) path = `/${up.alias}${path}`;
  return path;
}

/**
 * Returns the handle of the first object with a path of aliases; 0: none.
 * @param {string} path
 */
export function objectAt(path) {
  if (!path) return 0;
  for (const id of scene.objects.keys()) if (pathOf(id) === path) return id;
  return 0;
}
