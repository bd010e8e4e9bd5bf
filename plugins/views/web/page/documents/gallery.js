// @ts-check
// The gallery: a dialog in which the user opens a scene.

import { get, make } from "tatu/lib/dom";
import { failure } from "tatu/net/calls";
import { ask, on, send } from "tatu/net/connection";
import { line } from "tatu/scene/messages";
import { scene, watch } from "tatu/scene/store";
import { mayLeave } from "tatu/documents/scene_file";
import { sendPicture } from "tatu/documents/scene_pictures";

/** @import { SceneFile } from "tatu/protocol" */

const dialog = get("dialog", HTMLDialogElement);
const files = get("files");
const find = get("find-scene", HTMLInputElement);

/** Opens the gallery. */
export function browse() {
  // The list includes the picture of the open scene, so the picture is updated first.
  sendPicture();
  send({ type: "files" });
  find.value = "";
  if (!dialog.open) dialog.showModal();
}

/**
 * Opens a scene after asking about unsaved changes.
 * @param {string} file
 * @param {boolean} [asked] whether the user has already been asked
 */
export async function openScene(file, asked = false) {
  sendPicture();
  if (dialog.open) dialog.close();
  if (!asked && !(await mayLeave())) return;
  try {
    await ask({ type: "open", file }, `opening ${file}`);
  } catch (e) {
    const { error, help } = failure(e);
    line("Status", help ? `${error} (${help})` : error, "error");
  }
}

/**
 * Returns the displayed name of a scene: the name of its file, or the name of the model for the demo of a model.
 * @param {string} file
 */
function title(file) {
  const parts = file.split(/[\\/]/);
  const last = parts.pop() ?? "";
  const name = last === "demo.toml" && parts.length ? parts.pop() ?? "" : last.replace(/\.toml$/, "");
  return name.replaceAll("_", " ");
}

/** Creates the card of a scene. @param {SceneFile} entry */
function card({ file, about, try: toTry, picture }) {
  const li = make("li");
  const b = make("button", { className: "scene" });
  b.onclick = () => { openScene(file); };
  b.title = file;
  if (picture) b.append(Object.assign(new Image(240, 150), { src: `data:image/png;base64,${picture}`, alt: "" }));
  b.append(make("strong", { textContent: title(file) }));
  if (about) b.append(make("small", { textContent: about }));
  if (toTry) b.append(make("small", { textContent: `Try: ${toTry}`, className: "try" }));
  li.append(b);
  return li;
}

/**
 * Creates a section of the gallery: a heading and cards.
 * @param {string} name
 * @param {SceneFile[]} all
 */
function section(name, all) {
  const own = make("section");
  const list = make("ul");
  list.append(...all.map(card));
  own.append(make("h3", { textContent: name }), list);
  return own;
}

const none = make("p", { id: "no-scene" });

on("files", ({ files: all, folder }) => {
  /** @type {[SceneFile["in"], string][]} */
  const sections = [["recent", "Recent"], ["own", folder ? `Yours: ${folder}` : "Yours"], ["program", "Comes with Tatu"]];
  const shown = sections.flatMap(([key, name]) => {
    const cards = all.filter((f) => f.in === key);
    return cards.length ? [section(name, cards)] : [];
  });
  none.textContent = shown.length ? "No scene matches the search." : "No scenes were found: drop one on the page.";
  files.replaceChildren(...shown, none);
  sift();
});

/** Hides the cards that do not contain all words of the search text. */
function sift() {
  const words = find.value.toLowerCase().split(/\s+/);
  let any = false;
  for (const own of files.querySelectorAll("section")) {
    let some = false;
    for (const li of own.querySelectorAll("li")) {
      const name = `${li.textContent} ${li.querySelector("button")?.title}`.toLowerCase();
      li.hidden = !words.every((word) => name.includes(word));
      some ||= !li.hidden;
    }
    own.hidden = !some;
    any ||= some;
  }
  none.hidden = any;
}
find.oninput = () => { if (files.childElementCount) sift(); };
get("gallery").onclick = browse;

let first = true;
watch("scene", () => {
  if (first && !scene.objects.size) browse();
  first = false;
});
