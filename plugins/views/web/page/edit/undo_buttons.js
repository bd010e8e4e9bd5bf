// @ts-check
// The buttons that undo and redo edits.

import { get } from "tatu/lib/dom";
import { known, redo, undo, watchEdits } from "tatu/scene/edits";
import { line, tell } from "tatu/scene/messages";
import { rights } from "tatu/scene/store";

/** Undoes or redoes an edit. @param {boolean} back whether to undo */
export async function step(back) {
  if (!rights.acts || known.state !== "stopped") return;
  try {
    const label = await (back ? undo() : redo());
    if (label) line("Status", `${back ? "Undone" : "Done again"}: ${label}`);
  } catch (thrown) {
    tell(thrown);
  }
}

get("undo").onclick = () => { step(true); };
get("redo").onclick = () => { step(false); };

const RUNS = "not while the simulation runs: a stop takes back what was changed since the start";

/**
 * Updates the button for undo or redo.
 * @param {string} id
 * @param {string} word "Undo" or "Redo"
 * @param {string} keys
 * @param {string | null} label of the next edit to be undone or redone
 */
function show(id, word, keys, label) {
  const b = get(id, HTMLButtonElement);
  const runs = known.state !== "stopped";
  b.disabled = !rights.acts || runs || !label;
  b.title = runs ? `${word}: ${RUNS}` : label ? `${word} ${label} (${keys})` : `Nothing to ${word.toLowerCase()}`;
}

watchEdits(({ undo: back, redo: ahead }) => {
  show("undo", "Undo", "Ctrl+Z", back);
  show("redo", "Redo", "Ctrl+Y", ahead);
});
