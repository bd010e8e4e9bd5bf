// @ts-check
// Resolves a conflict between two versions of a script: the one that was edited here, and the one that another client
// has saved in the meantime.

import { choose } from "tatu/lib/dialogs";
import { make } from "tatu/lib/dom";
import { mark, t } from "tatu/lib/language";

/**
 * Creates a labelled text field.
 * @param {string} name
 * @param {string} value
 */
function textPane(name, value) {
  const label = make("label");
  const area = make("textarea", { value, spellcheck: false });
  label.append(make("strong", { textContent: name }), area);
  return { label, area };
}

/**
 * Shows both versions side by side in a dialog, in which they can be edited. Returns a promise of the chosen text, or
 * of null if neither was chosen. `mine` in the result is whether the text must be saved.
 * @param {string} script name of the script
 * @param {string} mine
 * @param {string} theirs
 * @returns {Promise<{ mine: boolean, text: string } | null>}
 */
export async function resolveConflict(script, mine, theirs) {
  const [mineField, theirsField] = [textPane(t`Mine`, mine), textPane(t`Theirs`, theirs)];
  mineField.area.id = "mine";
  theirsField.area.id = "theirs";
  const panes = make("div", { className: "both" });
  panes.append(mineField.label, theirsField.label);
  // The user may merge parts of one text into the other before choosing it.
  const text = make("p", { textContent: t`Another page has saved this script since it was opened here. Copy what you need from one text to the other, then choose.` });
  const chosen = await choose(t`${script} was changed twice`, [text, panes], [mark("Keep mine"), mark("Take theirs"), mark("Cancel")], () => {
    panes.closest("dialog")?.classList.add("wide-dialog");
    mineField.area.focus();
  });
  if (chosen === "Keep mine") return { mine: true, text: mineField.area.value };
  if (chosen === "Take theirs" && theirsField.area.value === theirs) return { mine: false, text: theirs };
  return chosen === "Take theirs" ? { mine: true, text: theirsField.area.value } : null;
}
