// @ts-check
// Creates and saves scenes, and asks the user before unsaved changes would be lost.

import { ask, askText, choose } from "tatu/lib/dialogs";
import { get, make } from "tatu/lib/dom";
import { mark, t } from "tatu/lib/language";
import { failure } from "tatu/net/calls";
import { ask as request, call, on } from "tatu/net/connection";
import { editState, watchEdits } from "tatu/scene/edits";
import { reportError, writeLine } from "tatu/scene/messages";
import { rights } from "tatu/scene/store";

/**
 * Another source of unsaved changes, such as the script editor. `isUnsaved` returns whether there are any; `save` puts
 * them into the scene, and returns a promise of whether that succeeded; `mayClose` asks the user about them before another
 * scene is opened, and returns a promise of whether it may be.
 * @typedef {{ isUnsaved: () => boolean, save: () => Promise<boolean>, mayClose: () => Promise<boolean> }} UnsavedSource
 */
/** @type {UnsavedSource[]} */
const sources = [];

/**
 * Registers another source of unsaved changes. It must call `showUnsaved` whenever `isUnsaved` may have changed.
 * @param {UnsavedSource} source
 */
export function addUnsavedSource(source) {
  sources.push(source);
}

/** Returns whether there are changes that are not in the scene yet, such as the text in the script editor. */
export function hasTextsToSave() {
  return sources.some((source) => source.isUnsaved());
}

/** Puts changes that are not in the scene yet into it. Returns a promise of whether the scene has all of them now. */
export async function saveTexts() {
  for (const source of sources) if (source.isUnsaved() && !(await source.save())) return false;
  return true;
}

/**
 * Returns a path for display, without the leading `./` of paths in the working folder of the program.
 * @param {string} file
 */
function displayPath(file) {
  return file.replace(/^\.[\\/]/, "");
}

/** Puts the text in the script editor into the scene before it is saved, and says so if that is not possible. */
async function saveTextsFirst() {
  if (!(await saveTexts())) writeLine("Status", t`The file will not have the new text of the script, which is still in the editor`, "warning");
}

/**
 * Saves the scene, with the text in the script editor, to its own file, or asks for another one if that is not possible.
 * Returns a promise of whether the scene was saved.
 */
export async function save() {
  if (!rights.canControl) return false;
  await saveTextsFirst();
  return saveToFile(false);
}

/** Asks for a path and saves the scene to it, with the text in the script editor. */
async function saveAs() {
  if (!rights.canControl) return;
  await saveTextsFirst();
  await saveToOther();
}

/**
 * Saves the scene to its own file, or asks for another one if that is not possible. Returns a promise of whether the
 * scene was saved.
 * @param {boolean} overwrite whether to replace a file that has changed on disk
 * @returns {Promise<boolean>}
 */
async function saveToFile(overwrite) {
  if (!editState.on_disk || !/\.toml$/i.test(editState.file)) return saveToOther();
  try {
    await call("tatu.saveScene", "", overwrite);
    writeLine("Status", t`Saved ${displayPath(editState.file)}`);
    return true;
  } catch (thrown) {
    const { error, help } = failure(thrown);
    const isChangedOnDisk = /changed on disk/.test(error);
    const text = help ? `${error} (${help})` : error;
    const chosen = await ask(mark("The scene was not saved"), text, [mark("Save as"), ...(isChangedOnDisk ? [mark("Replace")] : []), mark("Cancel")]);
    if (chosen === "Save as") return saveToOther();
    return chosen === "Replace" ? saveToFile(true) : false;
  }
}

/**
 * Returns the path that is proposed for saving: in the folder of the scene if that is below the working folder,
 * otherwise in the working folder.
 */
function proposedPath() {
  const name = displayPath(editState.file || "scene.toml").replace(/\.\w+$/, "") + ".toml";
  const isInWorkingFolder = !/^([\\/]|\w:|\.\.)/.test(name);
  return isInWorkingFolder ? name : name.split(/[\\/]/).pop() ?? "scene.toml";
}

/**
 * Asks for a path and saves the scene to it. Returns a promise of whether the scene was saved.
 * @param {string} [proposed]
 * @returns {Promise<boolean>}
 */
async function saveToOther(proposed = proposedPath()) {
  const entered = await askText(mark("Save the scene as"), mark("A file in the folder in which the program was started:"), proposed, mark("Save"));
  if (entered === null) return false;
  const name = /\.toml$/i.test(entered) ? entered : `${entered}.toml`;
  return saveUnder(name, false);
}

/**
 * Saves the scene to a path. Returns a promise of whether the scene was saved.
 * @param {string} name
 * @param {boolean} overwrite whether to replace an existing file
 * @returns {Promise<boolean>}
 */
async function saveUnder(name, overwrite) {
  try {
    await call("tatu.saveScene", name, overwrite);
    writeLine("Status", t`Saved ${name}`);
    return true;
  } catch (thrown) {
    const { error, help } = failure(thrown);
    const chosen = await ask(mark("The scene was not saved"), help ? `${error} (${help})` : error, [mark("Another name"), mark("Replace"), mark("Cancel")]);
    if (chosen === "Another name") return saveToOther(name);
    return chosen === "Replace" && !overwrite ? saveUnder(name, true) : false;
  }
}

/**
 * Asks what to do with unsaved changes, if any. Returns a promise of whether the scene may be closed.
 * @returns {Promise<boolean>}
 */
export async function mayClose() {
  for (const source of sources) if (!(await source.mayClose())) return false;
  if (!editState.unsaved || !rights.canControl) return true;
  const name = editState.file.split(/[\\/]/).pop() || t`The scene`;
  const text = t`${name} has changes that have not been saved.`;
  const chosen = await ask(mark("Save the changes?"), text, [mark("Save"), mark("Discard"), mark("Cancel")]);
  if (chosen === "Save") return save();
  if (chosen !== "Discard") return false;
  // The backup copy of the changes is removed as well.
  await call("tatu.recover", false).catch(reportError);
  return true;
}

async function newScene() {
  if (!rights.canControl || !(await mayClose())) return;
  await call("tatu.newScene").catch(reportError);
}

get("new").onclick = newScene;
get("save").onclick = () => { save(); };
get("save-as").onclick = () => { saveAs(); };

/** Pattern of the file of the scene that a program shows if it was started without a scene. */
const NO_SCENE = /(^|[\\/])nothing\.toml$/;
/** Pattern of the file of a new scene that has never been saved. */
const UNTITLED = /(^|[\\/])untitled(-\d+)?\.toml$/;

/** Shows the name of the scene, and whether it or the text in the script editor has unsaved changes. */
export function showUnsaved() {
  const isUnsaved = editState.unsaved || hasTextsToSave();
  get("unsaved").hidden = !isUnsaved;
  const name = editState.file.split(/[\\/]/).pop() || t`no scene`;
  document.title = `${isUnsaved ? "\u25CF " : ""}${name} \u2014 Tatu`;
}
watchEdits(showUnsaved);
on("hello", ({ acts }) => {
  for (const id of ["new", "save", "save-as"]) get(id, HTMLButtonElement).disabled = !acts;
});

addEventListener("beforeunload", (e) => {
  if (rights.canControl && (editState.unsaved || hasTextsToSave())) e.preventDefault();
});

// Offers to restore the backup copy of unsaved changes that a crashed program has left.
let offeredRecovery = "";
watchEdits(async ({ recovery, file }) => {
  if (!rights.canControl || recovery === null) return;
  const key = `${file} ${recovery}`;
  if (offeredRecovery === key) return;
  offeredRecovery = key;
  const time = new Date(recovery * 1000).toLocaleString();
  const text = make("p", { textContent: t`The program ended unexpectedly. There is a copy of unsaved changes to ${displayPath(file)} from ${time}.` });
  const chosen = await choose(mark("Restore unsaved changes?"), [text], [mark("Restore"), mark("Discard"), mark("Later")]);
  if (chosen === "Restore" || chosen === "Discard") await call("tatu.recover", chosen === "Restore").catch(reportError);
});

// If the program was restarted without the scene that was open here, the page opens that scene again, so that the
// backup copy of its unsaved changes is offered.
let sceneBefore = "";
on("again", ({ restarted }) => {
  offeredRecovery = "";
  if (restarted) sceneBefore = editState.file;
});
watchEdits(async ({ file }) => {
  const previous = sceneBefore;
  sceneBefore = "";
  if (!previous || !rights.canControl || !NO_SCENE.test(file) || NO_SCENE.test(previous)) return;
  const reopened = UNTITLED.test(previous) ? call("tatu.newScene") : request({ type: "open", file: previous }, `opening ${previous}`);
  await reopened.catch(reportError);
});
