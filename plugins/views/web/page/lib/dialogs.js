// @ts-check
// Modal dialogs that ask the user a question. Titles, texts and names of buttons are translated here.

import { make } from "tatu/lib/dom";
import { mark, translate } from "tatu/lib/language";

/**
 * Shows a dialog. Returns a promise of the name of the chosen button, or of "" if the user pressed Escape.
 * @param {string} title
 * @param {Node[]} content
 * @param {string[]} buttons the first one is chosen by Enter
 * @param {() => void} [onShown] called when the dialog is visible
 * @returns {Promise<string>}
 */
export function choose(title, content, buttons, onShown) {
  const dialog = make("dialog", { className: "question" });
  dialog.setAttribute("aria-label", translate(title));
  const form = make("form", { method: "dialog" });
  const row = make("div", { className: "buttons" });
  row.append(...buttons.map((name) => make("button", { value: name, textContent: translate(name) })));
  form.append(make("h2", { textContent: translate(title) }), ...content, row);
  dialog.append(form);
  document.body.append(dialog);
  return new Promise((resolve) => {
    dialog.onclose = () => {
      dialog.remove();
      resolve(dialog.returnValue);
    };
    dialog.showModal();
    onShown?.();
  });
}

/**
 * Asks a question. Returns a promise of the name of the chosen button, or of "" if the user pressed Escape.
 * @param {string} title
 * @param {string} text
 * @param {string[]} buttons
 */
export function ask(title, text, buttons) {
  return choose(title, [make("p", { textContent: translate(text) })], buttons);
}

/**
 * Asks for a line of text. Returns a promise of the trimmed text, or of null if it is empty or the dialog was
 * cancelled.
 * @param {string} title
 * @param {string} text
 * @param {string} value
 * @param {string} button
 */
export async function askText(title, text, value, button) {
  const field = make("input", { value, className: "wide" });
  field.setAttribute("aria-label", translate(text));
  const chosen = await choose(title, [make("p", { textContent: translate(text) }), field], [button, mark("Cancel")], () => field.select());
  return chosen === button && field.value.trim() ? field.value.trim() : null;
}
