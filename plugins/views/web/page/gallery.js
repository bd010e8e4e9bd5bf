// @ts-check
// The gallery of scenes, to open one.

import { failure } from "tatu/calls";
import { get, make } from "tatu/dom";
import { ask, on, send } from "tatu/net";
import { sendPicture } from "tatu/pictures";
import { mayLeave } from "tatu/saving";
import { scene, watch } from "tatu/store";
import { line } from "tatu/output";

/** @import { SceneFile } from "tatu/protocol" */

const dialog = get("dialog", HTMLDialogElement);
const files = get("files");
const find = get("find-scene", HTMLInputElement);

export function browse() {
  // The list shows the open scene as it looks now.
  sendPicture();
  send({ type: "files" });
  find.value = "";
  if (!dialog.open) dialog.showModal();
}

/**
 * Opens a scene, once nothing is lost by it.
 * @param {string} file
 * @param {boolean} [asked] whether the person was asked about unsaved changes
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
 * What people call a scene: the name of its file; the demonstration of a model is named after the model.
 * @param {string} file
 */
function title(file) {
  const parts = file.split(/[\\/]/);
  const last = parts.pop() ?? "";
  const name = last === "demo.toml" && parts.length ? parts.pop() ?? "" : last.replace(/\.toml$/, "");
  return name.replaceAll("_", " ");
}

/** @param {SceneFile} entry */
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
 * A heading and its cards.
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
  none.textContent = shown.length ? "No scene is like this." : "There are no scenes here: drop one on the page.";
  files.replaceChildren(...shown, none);
  sift();
});

/** Shows the cards that contain each word that is looked for. */
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
