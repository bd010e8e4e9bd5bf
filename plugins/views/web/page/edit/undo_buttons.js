// @ts-check
// The buttons that undo and redo edits.

import { get } from "tatu/lib/dom";
import { editState, redo, undo, watchEdits } from "tatu/scene/edits";
import { reportError, writeLine } from "tatu/scene/messages";
import { rights } from "tatu/scene/store";

/** Undoes or redoes an edit. @param {boolean} isUndo whether to undo */
export async function undoOrRedo(isUndo) {
  if (!rights.canControl || editState.state !== "stopped") return;
  try {
    const label = await (isUndo ? undo() : redo());
    if (label) writeLine("Status", `${isUndo ? "Undone" : "Done again"}: ${label}`);
  } catch (thrown) {
    reportError(thrown);
  }
}

get("undo").onclick = () => { undoOrRedo(true); };
get("redo").onclick = () => { undoOrRedo(false); };

const RUNNING_TEXT = "not while the simulation runs; stopping it undoes all changes since the start";

/**
 * Updates the button for undo or redo.
 * @param {string} id
 * @param {string} word "Undo" or "Redo"
 * @param {string} keys
 * @param {string | null} label of the next edit to be undone or redone
 */
function updateButton(id, word, keys, label) {
  const b = get(id, HTMLButtonElement);
  const isRunning = editState.state !== "stopped";
  b.disabled = !rights.canControl || isRunning || !label;
  b.title = isRunning ? `${word}: ${RUNNING_TEXT}` : label ? `${word} ${label} (${keys})` : `Nothing to ${word.toLowerCase()}`;
}

watchEdits(({ undo: undoLabel, redo: redoLabel }) => {
  updateButton("undo", "Undo", "Ctrl+Z", undoLabel);
  updateButton("redo", "Redo", "Ctrl+Y", redoLabel);
});
