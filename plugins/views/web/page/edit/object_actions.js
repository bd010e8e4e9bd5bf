// @ts-check
// Actions on the selection: delete, copy, cut, paste, duplicate, attach, rename.

import { t } from "tatu/lib/language";
import { describeObjects, edit, newMergeKey } from "tatu/scene/edits";
import { isBelow, subtree, topmost } from "tatu/scene/hierarchy";
import { reportError, writeLine } from "tatu/scene/messages";
import { rights, scene, selectAll, selectWhenPresent, selection } from "tatu/scene/store";
import { groundAt, pointer, worldPosition } from "tatu/view/picking";

/** The copied or cut objects, without the objects below them. */
let clipboard = { ids: /** @type {number[]} */ ([]), cut: false };

/**
 * Returns these objects and all objects below them, parents first.
 * @param {number[]} ids
 */
function subtrees(ids) {
  return topmost(ids).flatMap(subtree);
}

/** Removes the selected objects and all objects below them. */
export async function remove() {
  const ids = topmost(selection());
  if (!rights.canControl || !ids.length) return;
  try {
    await edit(t`Delete ${describeObjects(ids)}`, [["tatu.remove", subtrees(ids)]]);
  } catch (thrown) {
    reportError(thrown);
  }
}

/** Copies or cuts the selected objects. @param {boolean} cut */
export function copyToClipboard(cut) {
  const ids = topmost(selection());
  if (!ids.length) return;
  clipboard = { ids, cut };
  writeLine("Status", cut ? t`Cut ${describeObjects(ids)}` : t`Copied ${describeObjects(ids)}`);
}

/** Returns whether objects have been copied or cut that can be pasted. */
export function hasCopied() {
  return topmost(clipboard.ids).length > 0;
}

/**
 * Copies objects with all objects below them, and selects the copies.
 * @param {string} word verb for the label of the edit
 * @param {number[]} ids
 * @param {number[]} offset offset of the copies, m
 * @param {number} parent of copies of objects with a parent that is not copied; 0: the world
 */
async function copy(word, ids, offset, parent) {
  const all = subtrees(ids);
  const [[copies] = []] = await edit(`${word} ${describeObjects(ids)}`, [["tatu.copy", all, parent, offset]]);
  selectWhenPresent(ids.map((id) => copies[all.indexOf(id)]));
}

/** Pastes the copied or cut objects at the pointer's position on the ground, or next to the originals. */
export async function paste() {
  const ids = topmost(clipboard.ids);
  const [first] = ids;
  if (!rights.canControl || first === undefined) return;
  const at = pointer() ? groundAt(pointer()) : null;
  const from = worldPosition(first);
  const offset = at ? [at.x - from.x, at.y - from.y, 0] : [0.3, 0.3, 0];
  try {
    if (clipboard.cut) {
      const merge = newMergeKey();
      for (const id of ids) {
        const { x, y, z } = worldPosition(id);
        await edit(t`Move ${describeObjects(ids)}`, [
          ["tatu.set", id, "object.parent", 0],
          ["tatu.set", id, "object.position", [x + (offset[0] ?? 0), y + (offset[1] ?? 0), z]],
        ], merge);
      }
      clipboard = { ids: [], cut: false };
      selectAll(ids);
    } else await copy(t`Paste`, ids, offset, 0);
  } catch (thrown) {
    reportError(thrown);
  }
}

/** Copies the selected objects to positions next to the originals, with the same parent if all have the same one. */
export async function duplicate() {
  const ids = topmost(selection());
  if (!rights.canControl || !ids.length) return;
  const parents = new Set(ids.map((id) => scene.objects.get(id)?.parent ?? 0));
  try {
    await copy(t`Duplicate`, ids, [0.3, 0.3, 0], parents.size === 1 ? [...parents][0] ?? 0 : 0);
  } catch (thrown) {
    reportError(thrown);
  }
}

/**
 * Attaches objects to another object, or to the world, without moving them.
 * @param {number[]} ids
 * @param {number} parent 0: the world
 */
export async function reparent(ids, parent) {
  const moved = topmost(ids).filter((id) => id !== parent && !isBelow(parent, id) && scene.objects.get(id)?.parent !== parent);
  if (!rights.canControl || !moved.length) return;
  const target = parent ? scene.objects.get(parent)?.alias ?? "" : t`the world`;
  try {
    await edit(t`Attach ${describeObjects(moved)} to ${target}`, moved.map((id) => ["tatu.set", id, "object.parent", parent]));
  } catch (thrown) {
    reportError(thrown);
  }
}

/**
 * Renames an object.
 * @param {number} id
 * @param {string} name
 */
export async function rename(id, name) {
  const o = scene.objects.get(id);
  if (!rights.canControl || !o || !name || name === o.alias) return;
  try {
    await edit(t`Rename ${o.alias} to ${name}`, [["tatu.set", id, "object.alias", name]]);
  } catch (thrown) {
    reportError(thrown);
  }
}
