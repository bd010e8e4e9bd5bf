// @ts-check
// Creates and saves scenes, and asks the user before unsaved changes would be lost.

import { ask, askText, choose } from "tatu/lib/dialogs";
import { get, make } from "tatu/lib/dom";
import { failure } from "tatu/net/calls";
import { ask as request, call, on } from "tatu/net/connection";
import { known, watchEdits } from "tatu/scene/edits";
import { line, tell } from "tatu/scene/messages";
import { rights } from "tatu/scene/store";

/** The `mayLeave` functions of other sources of unsaved changes. @type {(() => Promise<boolean>)[]} */
const guards = [];
/** The `isUnsaved` functions of other sources of unsaved changes. @type {(() => boolean)[]} */
const holders = [];

/**
 * Registers another source of unsaved changes, such as the script editor. `isUnsaved` returns whether there are any;
 * `mayLeave` asks the user about them before another scene is opened, and returns a promise of whether it may be.
 * @param {() => boolean} isUnsaved
 * @param {() => Promise<boolean>} mayLeave
 */
export function guard(isUnsaved, mayLeave) {
  holders.push(isUnsaved);
  guards.push(mayLeave);
}

/**
 * Returns a path for display, without the leading `./` of paths in the working folder of the program.
 * @param {string} file
 */
function short(file) {
  return file.replace(/^\.[\\/]/, "");
}

/**
 * Saves the scene to its own file, or asks for another one if that is not possible. Returns a promise of whether the
 * scene was saved.
 * @param {boolean} [over] whether to replace a file that has changed on disk
 * @returns {Promise<boolean>}
 */
export async function save(over = false) {
  if (!rights.acts) return false;
  if (!known.on_disk || !/\.toml$/i.test(known.file)) return saveAs();
  try {
    await call("tatu.saveScene", "", over);
    line("Status", `Saved ${short(known.file)}`);
    return true;
  } catch (thrown) {
    const { error, help } = failure(thrown);
    const changed = /changed on disk/.test(error);
    const text = help ? `${error} (${help})` : error;
    const chosen = await ask("The scene was not saved", text, changed ? ["Save as", "Replace", "Cancel"] : ["Save as", "Cancel"]);
    if (chosen === "Save as") return saveAs();
    return chosen === "Replace" ? save(true) : false;
  }
}

/**
 * Returns the path that is proposed for saving: in the folder of the scene if that is below the working folder,
 * otherwise in the working folder.
 */
function proposal() {
  const name = short(known.file || "scene.toml").replace(/\.\w+$/, "") + ".toml";
  const inside = !/^([\\/]|\w:|\.\.)/.test(name);
  return inside ? name : name.split(/[\\/]/).pop() ?? "scene.toml";
}

/**
 * Asks for a path and saves the scene to it. Returns a promise of whether the scene was saved.
 * @param {string} [proposed]
 * @returns {Promise<boolean>}
 */
export async function saveAs(proposed = proposal()) {
  if (!rights.acts) return false;
  const given = await askText("Save the scene as", "A file in the folder in which the program was started:", proposed, "Save");
  if (given === null) return false;
  const name = /\.toml$/i.test(given) ? given : `${given}.toml`;
  return saveUnder(name, false);
}

/**
 * Saves the scene to a path. Returns a promise of whether the scene was saved.
 * @param {string} name
 * @param {boolean} over whether to replace an existing file
 * @returns {Promise<boolean>}
 */
async function saveUnder(name, over) {
  try {
    await call("tatu.saveScene", name, over);
    line("Status", `Saved ${name}`);
    return true;
  } catch (thrown) {
    const { error, help } = failure(thrown);
    const chosen = await ask("The scene was not saved", help ? `${error} (${help})` : error, ["Another name", "Replace", "Cancel"]);
    if (chosen === "Another name") return saveAs(name);
    return chosen === "Replace" && !over ? saveUnder(name, true) : false;
  }
}

/**
 * Asks what to do with unsaved changes, if any. Returns a promise of whether the scene may be closed.
 * @returns {Promise<boolean>}
 */
export async function mayLeave() {
  for (const own of guards) if (!(await own())) return false;
  if (!known.unsaved || !rights.acts) return true;
  const text = `${known.file.split(/[\\/]/).pop() || "The scene"} has changes that have not been saved.`;
  const chosen = await ask("Save the changes?", text, ["Save", "Discard", "Cancel"]);
  if (chosen === "Save") return save();
  if (chosen !== "Discard") return false;
  // The backup copy of the changes is removed as well.
  await call("tatu.recover", false).catch(tell);
  return true;
}

async function newScene() {
  if (!rights.acts || !(await mayLeave())) return;
  await call("tatu.newScene").catch(tell);
}

get("new").onclick = newScene;
get("save").onclick = () => { save(); };
get("save-as").onclick = () => { saveAs(); };

/** Pattern of the file of the scene that a program shows if it was started without a scene. */
const NOTHING = /(^|[\\/])nothing\.toml$/;
/** Pattern of the file of a new scene that has never been saved. */
const UNTITLED = /(^|[\\/])untitled(-\d+)?\.toml$/;

watchEdits(({ unsaved }) => {
  get("unsaved").hidden = !unsaved;
  title();
});

function title() {
  const name = known.file.split(/[\\/]/).pop() || "no scene";
  document.title = `${known.unsaved ? "\u25CF " : ""}${name} \u2014 Tatu`;
}
on("hello", ({ acts }) => {
  for (const id of ["new", "save", "save-as"]) get(id, HTMLButtonElement).disabled = !acts;
});

addEventListener("beforeunload", (e) => {
  if (rights.acts && (known.unsaved || holders.some((is) => is()))) e.preventDefault();
});

// Offers to restore the backup copy of unsaved changes that a crashed program has left.
let offered = "";
watchEdits(async ({ recovery, file }) => {
  if (!rights.acts || recovery === null) return;
  const key = `${file} ${recovery}`;
  if (offered === key) return;
  offered = key;
  const when = new Date(recovery * 1000).toLocaleString();
  const text = make("p", { textContent: `The program ended unexpectedly. There is a copy of unsaved changes to ${short(file)} from ${when}.` });
  const chosen = await choose("Restore unsaved changes?", [text], ["Restore", "Discard", "Later"]);
  if (chosen === "Restore" || chosen === "Discard") await call("tatu.recover", chosen === "Restore").catch(tell);
});

// If the program was restarted without the scene that was open here, the page opens that scene again, so that the
// backup copy of its unsaved changes is offered.
let before = "";
on("again", ({ restarted }) => {
  offered = "";
  if (restarted) before = known.file;
});
watchEdits(async ({ file }) => {
  const was = before;
  before = "";
  if (!was || !rights.acts || !NOTHING.test(file) || NOTHING.test(was)) return;
  const opening = UNTITLED.test(was) ? call("tatu.newScene") : request({ type: "open", file: was }, `opening ${was}`);
  await opening.catch(tell);
});
