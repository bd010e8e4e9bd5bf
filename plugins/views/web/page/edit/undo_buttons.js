// @ts-check
// The buttons that undo and redo edits.

import { get } from "tatu/lib/dom";
import { t } from "tatu/lib/language";
import { editState, redo, undo, watchEdits } from "tatu/scene/edits";
import { reportError, writeLine } from "tatu/scene/messages";
import { rights } from "tatu/scene/store";

/** Undoes or redoes an edit. @param {boolean} isUndo whether to undo */
export async function undoOrRedo(isUndo) {
  if (!rights.canControl || editState.state !== "stopped") return;
  try {
    const label = await (isUndo ? undo() : redo());
    if (label) writeLine("Status", isUndo ? t`Undone: ${label}` : t`Done again: ${label}`);
  } catch (thrown) {
    reportError(thrown);
  }
}

get("undo").onclick = () => { undoOrRedo(true); };
get("redo").onclick = () => { undoOrRedo(false); };

const RUNNING_TEXT = t`Not while the simulation runs; stopping it undoes all changes since the start`;

/**
 * Updates the button for undo or redo.
 * @param {string} id
 * @param {string} title with the label of the next edit
 * @param {string} emptyTitle without an edit
 * @param {string | null} label of the next edit to be undone or redone
 */
function updateButton(id, title, emptyTitle, label) {
  const b = get(id, HTMLButtonElement);
  const isRunning = editState.state !== "stopped";
  b.disabled = !rights.canControl || isRunning || !label;
  b.title = isRunning ? RUNNING_TEXT : label ? title : emptyTitle;
}

watchEdits(({ undo: undoLabel, redo: redoLabel }) => {
  updateButton("undo", t`Undo ${undoLabel} (Ctrl+Z)`, t`Nothing to undo`, undoLabel);
  updateButton("redo", t`Redo ${redoLabel} (Ctrl+Y)`, t`Nothing to redo`, redoLabel);
});
