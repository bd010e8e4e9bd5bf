// @ts-check
// Edits objects in the tree: renames them, attaches them by a drag, and shows their context menu.

import { ask } from "tatu/lib/dialogs";
import { get, make } from "tatu/lib/dom";
import { openMenu } from "tatu/lib/menu";
import { edit } from "tatu/scene/edits";
import { tops } from "tatu/scene/hierarchy";
import { tell } from "tatu/scene/messages";
import { rights, scene, select, selected, selection } from "tatu/scene/store";
import { duplicate, remove, rename, reparent } from "tatu/edit/object_actions";
import { openScript } from "tatu/documents/script_editor";
import { rowOf } from "tatu/panels/tree";

const tree = get("tree");
/** Distance that the pointer must move before a press becomes a drag, pixels. */
const STILL = 4;

/** Replaces the name of the selected object in its row by a field in which it can be changed. */
export function renameSelected() {
  const id = selected();
  const name = rowOf(id)?.querySelector(".alias");
  const o = scene.objects.get(id);
  if (!rights.acts || !name || !o) return;
  const field = make("input", { value: o.alias, className: "alias" });
  field.setAttribute("aria-label", `Name of ${o.alias}`);
  let over = false;
  const end = (/** @type {boolean} */ keep) => {
    if (over) return;
    over = true;
    field.replaceWith(name);
    tree.focus({ preventScroll: true });
    if (keep) rename(id, field.value.trim());
  };
  field.onkeydown = (e) => {
    e.stopPropagation();
    if (e.key === "Enter") end(true);
    else if (e.key === "Escape") end(false);
  };
  field.onblur = () => end(true);
  for (const kind of ["click", "dblclick", "pointerdown"]) field.addEventListener(kind, (e) => e.stopPropagation());
  name.replaceWith(field);
  field.select();
}

// An object that is dropped on a row is attached to the object of that row; between two rows, to their parent; and
// below all rows, to the world.
/** @type {{ x: number, y: number, ids: number[], going: boolean } | null} */
let drag = null;
/** @type {HTMLElement | null} */
let marked = null;

/** Returns the row that contains an element, or null. @param {EventTarget | null} target */
function rowAt(target) {
  const row = target instanceof Element ? target.closest("#tree [data-id]") : null;
  return row instanceof HTMLElement ? row : null;
}

/**
 * Returns the target of a drop at the pointer: the new parent, and the row and position of the marker; null outside of
 * the tree.
 * @param {PointerEvent} e
 */
function goal(e) {
  const under = document.elementFromPoint(e.clientX, e.clientY);
  if (!under?.closest("#tree")) return null;
  const row = rowAt(under);
  if (!row) return { parent: 0, row: tree, place: "into" };
  const id = Number(row.dataset.id);
  const box = row.getBoundingClientRect();
  const part = (e.clientY - box.top) / box.height;
  if (part > 0.25 && part < 0.75) return { parent: id, row, place: "into" };
  return { parent: scene.objects.get(id)?.parent ?? 0, row, place: part < 0.5 ? "before" : "after" };
}

tree.addEventListener("pointerdown", (e) => {
  const id = Number(rowAt(e.target)?.dataset.id ?? 0);
  if (!id || e.button !== 0 || !rights.acts || e.target instanceof HTMLButtonElement) return;
  drag = { x: e.clientX, y: e.clientY, ids: selection().includes(id) ? selection() : [id], going: false };
});
function unmark() {
  marked?.removeAttribute("data-drop");
  marked = null;
}
addEventListener("pointermove", (e) => {
  if (!drag) return;
  drag.going ||= Math.hypot(e.clientX - drag.x, e.clientY - drag.y) > STILL;
  unmark();
  const found = drag.going ? goal(e) : null;
  if (!found) return;
  marked = found.row;
  marked.dataset.drop = found.place;
});
addEventListener("pointerup", (e) => {
  const was = drag;
  drag = null;
  unmark();
  if (!was?.going) return;
  // The browser reports a click after the drag, which must not select the object under the pointer.
  const swallow = (/** @type {Event} */ click) => click.stopPropagation();
  addEventListener("click", swallow, true);
  setTimeout(() => removeEventListener("click", swallow, true));
  const found = goal(e);
  if (found) reparent(was.ids, found.parent);
});

/** Source of a new script. */
const SCRIPT = "function sysCall_init()\nend\n\nfunction sysCall_actuation()\nend\n";

/** Adds a script to an object. @param {number} id */
async function addScript(id) {
  const name = scene.objects.get(id)?.alias ?? "object";
  await edit(`Add script to ${name}`, [["tatu.addScript", id, SCRIPT]]).catch(tell);
}

/** Removes the first script of an object after asking the user. @param {number} id */
async function removeScript(id) {
  const o = scene.objects.get(id);
  const script = o?.scripts?.[0];
  if (!o || !script) return;
  const chosen = await ask("Remove the script?", `The script ${script.name} will be removed. This can be undone.`, ["Remove", "Cancel"]);
  if (chosen === "Remove") await edit(`Remove script from ${o.alias}`, [["tatu.remove", [script.id]]]).catch(tell);
}

/**
 * Opens the context menu of the selection.
 * @param {number} x pixels
 * @param {number} y pixels
 */
function menu(x, y) {
  const id = selected();
  const o = scene.objects.get(id);
  if (!o) return;
  const one = selection().length === 1;
  const script = o.scripts?.[0];
  openMenu(x, y, [
    { name: "Rename", keys: "F2", act: renameSelected, off: !one || !rights.acts },
    { name: "Duplicate", keys: "Ctrl+D", act: duplicate, off: !rights.acts },
    { name: "Delete", keys: "Delete", act: remove, off: !rights.acts },
    { name: "Detach", keys: "", act: () => reparent(tops(selection()), 0), off: !rights.acts || !o.parent },
    { name: "Open script", keys: "Enter", act: () => { if (script) openScript(script); }, off: !one || !script },
    { name: "Add script", keys: "", act: () => addScript(id), off: !one || !rights.acts },
    { name: "Remove script", keys: "", act: () => removeScript(id), off: !one || !script || !rights.acts },
  ]);
}

tree.addEventListener("contextmenu", (e) => {
  const id = Number(rowAt(e.target)?.dataset.id ?? 0);
  e.preventDefault();
  if (id && !selection().includes(id)) select(id);
  const box = rowOf(selected())?.getBoundingClientRect();
  // If the menu key was pressed, the event has no position, so the menu opens at the row.
  if (id) menu(e.clientX, e.clientY);
  else if (box) menu(box.left + 20, box.bottom);
});
