// @ts-check
// Restores the objects of models that a message with a scene describes as copies of others. This module does not access
// the DOM, so it can be tested without a browser.

/** @import { SceneEntry, SceneObject } from "tatu/protocol" */

/**
 * Returns the objects of a scene.
 * @param {SceneEntry[]} entries
 * @returns {SceneObject[]}
 */
export function expandCopies(entries) {
  /** @type {SceneObject[]} */
  const objects = [];
  /** The objects of each model without a parent, by the handle of its root. @type {Map<number, SceneObject[]>} */
  const models = new Map();
  /** The model of each object, by its handle. @type {Map<number, SceneObject[]>} */
  const modelOf = new Map();
  /** @param {SceneObject} object */
  function add(object) {
    const model = modelOf.get(object.parent) ?? [];
    if (!model.length) models.set(object.id, model);
    model.push(object);
    modelOf.set(object.id, model);
    objects.push(object);
  }
  for (const entry of entries) {
    if (!("copy_of" in entry)) {
      add(entry);
      continue;
    }
    const original = models.get(entry.copy_of) ?? [];
    const handles = new Map(original.map((object, i) => [object.id, entry.ids[i] ?? 0]));
    let scripts = 0;
    for (const [i, object] of original.entries()) {
      const copy = { ...object, id: entry.ids[i] ?? 0, pose: entry.poses[i] ?? object.pose };
      if (i) copy.parent = handles.get(object.parent) ?? 0;
      else copy.alias = entry.alias;
      if (object.scripts) copy.scripts = entry.scripts.slice(scripts, (scripts += object.scripts.length));
      add(copy);
    }
  }
  return objects;
}
