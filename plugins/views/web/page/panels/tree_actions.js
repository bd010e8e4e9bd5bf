// @ts-check
// Edits objects in the tree: renames them, attaches them by a drag, and shows their context menu.

import { ask } from "tatu/lib/dialogs";
import { get, make } from "tatu/lib/dom";
import { mark, t } from "tatu/lib/language";
import { openMenu } from "tatu/lib/menu";
import { edit } from "tatu/scene/edits";
import { subtree, topmost } from "tatu/scene/hierarchy";
import { reportError } from "tatu/scene/messages";
import { TYPE } from "tatu/scene/property_format";
import { rights, scene, select, selected, selection } from "tatu/scene/store";
import { fitSelection, followSelection } from "tatu/view/camera_controls";
import { copyToClipboard, duplicate, hasCopied, paste, remove, rename, reparent } from "tatu/edit/object_actions";
import { openNewScript, openScript } from "tatu/documents/script_editor";
import { plotRow } from "tatu/windows/plot_window";
import { rowOf } from "tatu/panels/tree";

const tree = get("tree");
/** Distance that the pointer must move before a press becomes a drag, pixels. */
const CLICK_TOLERANCE = 4;

/** Replaces the name of the selected object in its row by a field in which it can be changed. */
export function renameSelected() {
  const id = selected();
  const name = rowOf(id)?.querySelector(".alias");
  const o = scene.objects.get(id);
  if (!rights.canControl || !name || !o) return;
  const field = make("input", { value: o.alias, className: "alias" });
  field.setAttribute("aria-label", t`Name of ${o.alias}`);
  let isDone = false;
  const end = (/** @type {boolean} */ isAccepted) => {
    if (isDone) return;
    isDone = true;
    field.replaceWith(name);
    tree.focus({ preventScroll: true });
    if (isAccepted) rename(id, field.value.trim());
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
/** @type {{ x: number, y: number, ids: number[], isDragging: boolean } | null} */
let drag = null;
/** @type {HTMLElement | null} */
let markedRow = null;

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
function dropTarget(e) {
  const element = document.elementFromPoint(e.clientX, e.clientY);
  if (!element?.closest("#tree")) return null;
  const row = rowAt(element);
  if (!row) return { parent: 0, row: tree, place: "into" };
  const id = Number(row.dataset.id);
  const box = row.getBoundingClientRect();
  const part = (e.clientY - box.top) / box.height;
  if (part > 0.25 && part < 0.75) return { parent: id, row, place: "into" };
  return { parent: scene.objects.get(id)?.parent ?? 0, row, place: part < 0.5 ? "before" : "after" };
}

tree.addEventListener("pointerdown", (e) => {
  const id = Number(rowAt(e.target)?.dataset.id ?? 0);
  if (!id || e.button !== 0 || !rights.canControl || e.target instanceof HTMLButtonElement) return;
  drag = { x: e.clientX, y: e.clientY, ids: selection().includes(id) ? selection() : [id], isDragging: false };
});
function removeMarker() {
  markedRow?.removeAttribute("data-drop");
  markedRow = null;
}
addEventListener("pointermove", (e) => {
  if (!drag) return;
  drag.isDragging ||= Math.hypot(e.clientX - drag.x, e.clientY - drag.y) > CLICK_TOLERANCE;
  removeMarker();
  const found = drag.isDragging ? dropTarget(e) : null;
  if (!found) return;
  markedRow = found.row;
  markedRow.dataset.drop = found.place;
});
addEventListener("pointerup", (e) => {
  const ended = drag;
  drag = null;
  removeMarker();
  if (!ended?.isDragging) return;
  // The browser reports a click after the drag, which must not select the object under the pointer.
  const swallow = (/** @type {Event} */ click) => click.stopPropagation();
  addEventListener("click", swallow, true);
  setTimeout(() => removeEventListener("click", swallow, true));
  const found = dropTarget(e);
  if (found) reparent(ended.ids, found.parent);
});

/** Source of a new script. */
const SCRIPT = "function sysCall_init()\nend\n\nfunction sysCall_actuation()\nend\n";

/** Adds a script to an object, and opens it. @param {number} id */
async function addScript(id) {
  const name = scene.objects.get(id)?.alias ?? "object";
  try {
    const [[created] = []] = await edit(t`Add script to ${name}`, [["tatu.addScript", id, SCRIPT]]);
    openNewScript(created);
  } catch (thrown) {
    reportError(thrown);
  }
}

// A double click on an object opens its script (in the tree), and on a model without any script adds one.
tree.addEventListener("dblclick", (e) => {
  const id = Number(rowAt(e.target)?.dataset.id ?? 0);
  const isTool = e.target instanceof Element && e.target.closest("button, input, .twist") !== null;
  if (isTool || !rights.canControl || !scene.objects.get(id)?.model) return;
  if (!subtree(id).some((below) => scene.objects.get(below)?.scripts?.length)) addScript(id);
});

/** Removes the first script of an object after asking the user. @param {number} id */
async function removeScript(id) {
  const o = scene.objects.get(id);
  const script = o?.scripts?.[0];
  if (!o || !script) return;
  const chosen = await ask(mark("Remove the script?"), t`The script ${script.name} will be removed. This can be undone.`, [mark("Remove"), mark("Cancel")]);
  if (chosen === "Remove") await edit(t`Remove script from ${o.alias}`, [["tatu.remove", [script.id]]]).catch(reportError);
}

/** Plots the position of an object, or of a joint. @param {number} id */
function plotPosition(id) {
  const isJoint = scene.objects.get(id)?.kind === "joint";
  const position = isJoint ? { key: "joint.position", value: 0, unit: "rad|m" } : { key: "object.position", value: [0, 0, 0], unit: "m" };
  plotRow(id, { type: TYPE.floats, count: 0, text: "", settable: false, choices: [], ...position });
}

/**
 * Opens the context menu of the selection.
 * @param {number} x pixels
 * @param {number} y pixels
 */
function openContextMenu(x, y) {
  const id = selected();
  const o = scene.objects.get(id);
  if (!o) return;
  const isSingle = selection().length === 1;
  const script = o.scripts?.[0];
  openMenu(x, y, [
    { name: mark("Fit into the view"), keys: "F", action: fitSelection, isDisabled: false },
    { name: mark("Follow"), keys: "", action: followSelection, isDisabled: !isSingle },
    { name: mark("Plot position"), keys: "", action: () => plotPosition(id), isDisabled: !isSingle },
    { name: mark("Rename"), keys: "F2", action: renameSelected, isDisabled: !isSingle || !rights.canControl },
    { name: mark("Copy"), keys: "Ctrl+C", action: () => copyToClipboard(false), isDisabled: !rights.canControl },
    { name: mark("Cut"), keys: "Ctrl+X", action: () => copyToClipboard(true), isDisabled: !rights.canControl },
    { name: mark("Paste"), keys: "Ctrl+V", action: paste, isDisabled: !rights.canControl || !hasCopied() },
    { name: mark("Duplicate"), keys: "Ctrl+D", action: duplicate, isDisabled: !rights.canControl },
    { name: mark("Delete"), keys: "Delete", action: remove, isDisabled: !rights.canControl },
    { name: mark("Detach"), keys: "", action: () => reparent(topmost(selection()), 0), isDisabled: !rights.canControl || !o.parent },
    { name: mark("Open script"), keys: "Enter", action: () => { if (script) openScript(script); }, isDisabled: !isSingle || !script },
    { name: mark("Add script and open it"), keys: "", action: () => addScript(id), isDisabled: !isSingle || !rights.canControl },
    { name: mark("Remove script"), keys: "", action: () => removeScript(id), isDisabled: !isSingle || !script || !rights.canControl },
  ]);
}

tree.addEventListener("contextmenu", (e) => {
  const id = Number(rowAt(e.target)?.dataset.id ?? 0);
  e.preventDefault();
  if (id && !selection().includes(id)) select(id);
  const box = rowOf(selected())?.getBoundingClientRect();
  // If the menu key was pressed, the event has no position, so the menu opens at the row.
  if (id) openContextMenu(e.clientX, e.clientY);
  else if (box) openContextMenu(box.left + 20, box.bottom);
});
