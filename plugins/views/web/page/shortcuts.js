// @ts-check
// Keyboard shortcuts that work whenever no text is being typed.

import { duplicate, hold, paste, remove } from "tatu/clipboard";
import { known } from "tatu/edits";
import { save, step } from "tatu/saving";
import { selectAbove } from "tatu/selecting";
import { renameSelected } from "tatu/treeing";
import { fitSelection } from "tatu/looking";
import { host } from "tatu/view";
import { isPlacing } from "tatu/placing";

/** Returns whether keys are handled by a field, an editor or a dialog. */
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

// Registered for the capture phase, because all other keys in the view go to the simulation.
document.addEventListener("keydown", (e) => {
  if (e.altKey) return;
  const ctrl = e.ctrlKey || e.metaKey;
  const key = e.key.length === 1 ? e.key.toLowerCase() : e.key;
  if (ctrl && key === "s") {
    // In the editor, the same keys save the script.
    if (document.activeElement?.closest("#editor") || document.querySelector("dialog[open]")) return;
    e.preventDefault();
    // A field accepts its text when it loses the focus.
    if (isWriting() && document.activeElement instanceof HTMLElement) document.activeElement.blur();
    save();
    return;
  }
  // Menus, windows and the palette handle Escape themselves.
  if (isWriting() || isPlacing() || document.activeElement?.closest(".menu, #palette, .pane")) return;
  // During a run, keys that are pressed in the view are passed to scripts.
  if (!ctrl && known.state !== "stopped" && document.activeElement === host) return;
  let act = ctrl ? WITH_CTRL[key] : e.shiftKey ? undefined : ALONE[key];
  if (ctrl && e.shiftKey) act = key === "z" ? () => step(false) : undefined;
  // If text is selected, it is copied as text.
  if (!act || (ctrl && key === "c" && !getSelection()?.isCollapsed)) return;
  e.preventDefault();
  e.stopPropagation();
  act();
}, true);
