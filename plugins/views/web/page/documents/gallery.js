// @ts-check
// The gallery: a dialog in which the user opens a scene.

import { get, make } from "tatu/lib/dom";
import { inlineNodes } from "tatu/lib/inline_text";
import { mark, t, translate } from "tatu/lib/language";
import { failure } from "tatu/net/calls";
import { ask, on, send } from "tatu/net/connection";
import { writeLine } from "tatu/scene/messages";
import { scene, watch } from "tatu/scene/store";
import { mayClose } from "tatu/documents/scene_file";
import { sendPicture } from "tatu/documents/scene_pictures";

/** @import { SceneFile } from "tatu/protocol" */

const dialog = get("dialog", HTMLDialogElement);
const files = get("files");
const searchField = get("find-scene", HTMLInputElement);
/** Sections of scenes that come with the program, in order, by the name of their folder. */
const PROGRAM_SECTIONS = { course: mark("Course"), first: mark("First steps"), learn: mark("Learning"), showcase: mark("Showcase"), models: mark("Models") };
/** The section of other scenes. */
const OTHER = mark("Other");

/** Opens the gallery. */
export function openGallery() {
  // The list includes the picture of the open scene, so the picture is updated first.
  sendPicture();
  send({ type: "files" });
  files.setAttribute("aria-busy", "true");
  searchField.value = "";
  if (!dialog.open) dialog.showModal();
}

/**
 * Opens a scene after asking about unsaved changes.
 * @param {string} file
 * @param {boolean} [isConfirmed] whether the user has already been asked
 */
export async function openScene(file, isConfirmed = false) {
  sendPicture();
  if (dialog.open) dialog.close();
  if (!isConfirmed && !(await mayClose())) return;
  try {
    await ask({ type: "open", file }, `opening ${file}`);
  } catch (e) {
    const { error, help } = failure(e);
    writeLine("Status", help ? `${error} (${help})` : error, "error");
  }
}

/**
 * Returns the displayed name of a scene: the name of its file, or the name of the model for the demo of a model.
 * @param {string} file
 */
function title(file) {
  const parts = file.split(/[\\/]/);
  const fileName = parts.pop() ?? "";
  const name = fileName === "demo.toml" && parts.length ? parts.pop() ?? "" : fileName.replace(/\.toml$/, "");
  return name.replaceAll("_", " ");
}

/** Creates the card of a scene. @param {SceneFile} entry */
function card({ file, about, try: suggestion, picture }) {
  const li = make("li");
  const b = make("button", { className: "scene" });
  b.onclick = () => { openScene(file); };
  b.title = file;
  if (picture) b.append(Object.assign(new Image(240, 150), { src: `data:image/png;base64,${picture}`, alt: "" }));
  b.append(make("strong", { textContent: title(file) }));
  const addText = (/** @type {string} */ text, className = "") => {
    const element = make("small", { className });
    element.append(...inlineNodes(text));
    b.append(element);
  };
  if (about) addText(about);
  if (suggestion) addText(`${t`Try:`} ${suggestion}`, "try");
  li.append(b);
  return li;
}

/**
 * Creates a section of the gallery: a heading and cards.
 * @param {string} name
 * @param {SceneFile[]} all
 */
function section(name, all) {
  const element = make("section");
  const cardList = make("ul");
  cardList.append(...all.map(card));
  element.append(make("h3", { textContent: translate(name) }), cardList);
  return element;
}

const emptyText = make("p", { id: "no-scene" });

/** Returns the name of the section of a scene that comes with the program. @param {string} file */
function programSection(file) {
  const folders = file.split(/[\\/]/).slice(0, -1);
  const known = Object.entries(PROGRAM_SECTIONS).find(([folder]) => folders.slice(-2).includes(folder));
  return known?.[1] ?? OTHER;
}

/**
 * Divides the list of scenes into sections: a heading, and the scenes.
 * @param {SceneFile[]} all
 * @param {string} folder the working folder of the program
 * @returns {[string, SceneFile[]][]}
 */
function sectionsOf(all, folder) {
  const of = (/** @type {SceneFile["in"]} */ where) => all.filter((f) => f.in === where);
  const program = [...Object.values(PROGRAM_SECTIONS), OTHER].map((name) =>
    /** @type {[string, SceneFile[]]} */ ([name, of("program").filter((f) => programSection(f.file) === name)]));
  const sections = [[t`Recent`, of("recent")], [folder ? t`Yours: ${folder}` : t`Yours`, of("own")], ...program];
  return /** @type {[string, SceneFile[]][]} */ (sections).filter(([, scenes]) => scenes.length);
}

/** The list that is shown, as text. */
let shownList = "";

on("files", ({ files: all, folder }) => {
  files.removeAttribute("aria-busy");
  // Cards stay if the list is the same, since a click on a card that is replaced would be lost.
  const list = JSON.stringify([all, folder]);
  if (list === shownList) return;
  shownList = list;
  const shown = sectionsOf(all, folder).map(([name, scenes]) => section(name, scenes));
  emptyText.textContent = shown.length ? t`No scene matches the search.` : t`No scenes were found: drop one on the page.`;
  files.replaceChildren(...shown, emptyText);
  filterCards();
});

/** Hides the cards that do not contain all words of the search text. */
function filterCards() {
  const words = searchField.value.toLowerCase().split(/\s+/);
  let isAnyShown = false;
  for (const element of files.querySelectorAll("section")) {
    let isSectionShown = false;
    for (const li of element.querySelectorAll("li")) {
      const name = `${li.textContent} ${li.querySelector("button")?.title}`.toLowerCase();
      li.hidden = !words.every((word) => name.includes(word));
      isSectionShown ||= !li.hidden;
    }
    element.hidden = !isSectionShown;
    isAnyShown ||= isSectionShown;
  }
  emptyText.hidden = isAnyShown;
}
searchField.oninput = () => { if (files.childElementCount) filterCards(); };
get("gallery").onclick = openGallery;

let isFirstScene = true;
watch("scene", () => {
  if (isFirstScene && !scene.objects.size) openGallery();
  isFirstScene = false;
});
