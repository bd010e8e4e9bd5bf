// @ts-check
// Shows two versions of a script side by side: the one edited here, and the one that another client saved in the
// meantime.

import { choose } from "tatu/dialogs";
import { make } from "tatu/dom";

/**
 * @param {string} name
 * @param {string} value
 */
function pane(name, value) {
  const label = make("label");
  const area = make("textarea", { value, spellcheck: false });
  label.append(make("strong", { textContent: name }), area);
  return { label, area };
}

/**
 * Shows both texts, which can be edited; returns a promise of the chosen text, or of null if neither was chosen.
 * @param {string} script
 * @param {string} mine
 * @param {string} theirs
 * @returns {Promise<{ mine: boolean, text: string } | null>}
 */
export async function resolve(script, mine, theirs) {
  const [own, other] = [pane("Mine", mine), pane("Theirs", theirs)];
  own.area.id = "mine";
  other.area.id = "theirs";
  const both = make("div", { className: "both" });
  both.append(own.label, other.label);
  // The chosen text is that of the pane, into which parts of the other may have been merged.
  const text = make("p", { textContent: "Another page has saved this script since it was opened here. Carry over what you need, then choose." });
  const chosen = await choose(`${script} was changed twice`, [text, both], ["Keep mine", "Take theirs", "Cancel"], () => {
    both.closest("dialog")?.classList.add("wide-dialog");
    own.area.focus();
  });
  if (chosen === "Keep mine") return { mine: true, text: own.area.value };
  if (chosen === "Take theirs" && other.area.value === theirs) return { mine: false, text: theirs };
  return chosen === "Take theirs" ? { mine: true, text: other.area.value } : null;
}
