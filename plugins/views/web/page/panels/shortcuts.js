// @ts-check
// Keyboard shortcuts. They work unless text is being typed or a dialog is open.

import { known } from "tatu/scene/edits";
import { fitSelection } from "tatu/view/camera_controls";
import { host } from "tatu/view/renderer";
import { duplicate, hold, paste, remove } from "tatu/edit/object_actions";
import { isPlacing } from "tatu/edit/placement";
import { step } from "tatu/edit/undo_buttons";
import { selectAbove } from "tatu/edit/view_selection";
import { save } from "tatu/documents/scene_file";
import { renameSelected } from "tatu/panels/tree_actions";

/** Returns whether a field or an editor has the focus, or a dialog is open. */
function isWriting() {
  const e = document.activeElement;
  const inField = e instanceof HTMLElement && (e.isContentEditable || /^(INPUT|TEXTAREA|SELECT)$/.test(e.tagName));
  return (inField && !(e instanceof HTMLInputElement && e.type === "checkbox")) || document.querySelector("dialog[open]") !== null;
}

/** @type {{ [key: string]: () => void }} */
const WITH_CTRL = {
  z: () => step(true), y: () => step(false), c: () => hold(false), x: () => hold(true), v: paste, d: duplicate,
};
/** @type {{ [key: string]: () => void }} */
const ALONE = { Delete: remove, f: fitSelection, F2: renameSelected, Escape: selectAbove };

// Registered for the capture phase, so that the simulation receives only keys that are not shortcuts.
document.addEventListener("keydown", (e) => {
  if (e.altKey) return;
  const ctrl = e.ctrlKey || e.metaKey;
  const key = e.key.length === 1 ? e.key.toLowerCase() : e.key;
  if (ctrl && key === "s") {
    // In the script editor, Ctrl+S saves the script instead.
    if (document.activeElement?.closest("#editor") || document.querySelector("dialog[open]")) return;
    e.preventDefault();
    // The text of a field is applied when the field loses the focus.
    if (isWriting() && document.activeElement instanceof HTMLElement) document.activeElement.blur();
    save();
    return;
  }
  // Menus, windows and the palette handle keys such as Escape themselves.
  if (isWriting() || isPlacing() || document.activeElement?.closest(".menu, #palette, .pane")) return;
  // During a run, keys without Ctrl that are pressed in the view are passed to scripts.
  if (!ctrl && known.state !== "stopped" && document.activeElement === host) return;
  let act = ctrl ? WITH_CTRL[key] : e.shiftKey ? undefined : ALONE[key];
  if (ctrl && e.shiftKey) act = key === "z" ? () => step(false) : undefined;
  // If text is selected, Ctrl+C copies that text.
  if (!act || (ctrl && key === "c" && !getSelection()?.isCollapsed)) return;
  e.preventDefault();
  e.stopPropagation();
  act();
}, true);
