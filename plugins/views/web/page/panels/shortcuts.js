// @ts-check
// Keyboard shortcuts. They work unless text is being typed or a dialog is open.

import { editState } from "tatu/scene/edits";
import { fitSelection } from "tatu/view/camera_controls";
import { host } from "tatu/view/renderer";
import { copyToClipboard, duplicate, paste, remove } from "tatu/edit/object_actions";
import { isPlacing } from "tatu/edit/placement";
import { undoOrRedo } from "tatu/edit/undo_buttons";
import { selectModelAbove } from "tatu/edit/view_selection";
import { save } from "tatu/documents/scene_file";
import { renameSelected } from "tatu/panels/tree_actions";

/** Returns whether a field or an editor has the focus, or a dialog is open. */
function isTyping() {
  const e = document.activeElement;
  const inField = e instanceof HTMLElement && (e.isContentEditable || /^(INPUT|TEXTAREA|SELECT)$/.test(e.tagName));
  return (inField && !(e instanceof HTMLInputElement && e.type === "checkbox")) || document.querySelector("dialog[open]") !== null;
}

/** @type {{ [key: string]: () => void }} */
const WITH_CTRL = {
  z: () => undoOrRedo(true), y: () => undoOrRedo(false), c: () => copyToClipboard(false), x: () => copyToClipboard(true), v: paste, d: duplicate,
};
/** @type {{ [key: string]: () => void }} */
const WITHOUT_MODIFIERS = { Delete: remove, f: fitSelection, F2: renameSelected, Escape: selectModelAbove };

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
    if (isTyping() && document.activeElement instanceof HTMLElement) document.activeElement.blur();
    save();
    return;
  }
  // Menus, windows and the palette handle keys such as Escape themselves.
  if (isTyping() || isPlacing() || document.activeElement?.closest(".menu, #palette, .pane")) return;
  // During a run, keys without Ctrl that are pressed in the view are passed to scripts.
  if (!ctrl && editState.state !== "stopped" && document.activeElement === host) return;
  let action = ctrl ? WITH_CTRL[key] : e.shiftKey ? undefined : WITHOUT_MODIFIERS[key];
  if (ctrl && e.shiftKey) action = key === "z" ? () => undoOrRedo(false) : undefined;
  // If text is selected, Ctrl+C copies that text.
  if (!action || (ctrl && key === "c" && !getSelection()?.isCollapsed)) return;
  e.preventDefault();
  e.stopPropagation();
  action();
}, true);
