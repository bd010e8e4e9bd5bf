// @ts-check
// The script editor: opens, completes and saves scripts.

import { ask as question } from "tatu/lib/dialogs";
import { get } from "tatu/lib/dom";
import { language, mark, t } from "tatu/lib/language";
import { failure } from "tatu/net/calls";
import { ask, on, send } from "tatu/net/connection";
import { editState } from "tatu/scene/edits";
import { reportError, writeLine } from "tatu/scene/messages";
import { rights, scene, watch } from "tatu/scene/store";
import { addUnsavedSource, showUnsaved } from "tatu/documents/scene_file";
import { draftOf, isSameScene, placeOf, removeDraft, scriptAt, storeDraft } from "tatu/documents/script_drafts";
import { resolveConflict } from "tatu/documents/version_conflict";

/** @import { CompletionContext } from "@codemirror/autocomplete" */
/** @import { EditorView } from "@codemirror/view" */
/** @import { Command, Script } from "tatu/protocol" */

/** @type {EditorView | null} */
let editorView = null;
/** The module that creates the text field, after it has been loaded. @type {typeof import("tatu/documents/code_field") | null} */
let codeFieldModule = null;
/** The script that was opened. @type {Script | null} */
let openedScript = null;
/** The file of the scene that contains the opened script, and the place of the script in the scene. */
let home = { file: "", place: "" };
/** The source of the script in the scene when it was last opened or saved, and its version. */
let saved = { text: "", version: 0 };
/** Handle of the script whose source is in the text field; 0: none. */
let shownScript = 0;
/** @type {Command[] | null} */
let commands = null;

/** Completes the names of commands. @param {CompletionContext} context */
function complete(context) {
  const word = context.matchBefore(/[\w.]+/);
  if (!word || (word.from === word.to && !context.explicit)) return null;
  return {
    from: word.from,
    options: (commands ?? []).map(({ name, params, text }) => ({ label: name, detail: `(${params})`, info: text, type: "function" })),
    validFor: /^[\w.]*$/,
  };
}

let fillCount = 0;
/** Creates the text field with a text. @param {string} text */
async function fill(text) {
  const number = ++fillCount;
  editorView?.destroy();
  editorView = null;
  const loaded = await import("tatu/documents/code_field");
  // Another script may have been opened while the libraries were being loaded.
  if (number !== fillCount) return;
  codeFieldModule = loaded;
  const isPython = openedScript?.language === "python";
  editorView = loaded.textField({ parent: get("editor"), text, complete, save: () => { save(); }, changed: textChanged, readOnly: !rights.canControl, isPython });
  editorView.focus();
  showUnsaved();
}

/** Returns a text with the line feeds of the text field, which has no carriage returns. @param {string} text */
const withLineFeeds = (text) => text.replace(/\r\n?/g, "\n");

/** Time after the last change at which the text is stored in the browser, ms. */
const DRAFT_DELAY = 1000;
let draftTimer = 0;
/** Shows that the text is unsaved, and keeps it soon, since a browser that crashes sends no event. */
function textChanged() {
  showUnsaved();
  clearTimeout(draftTimer);
  draftTimer = setTimeout(() => { if (!keepDraft() && openedScript) forgetDraft(); }, DRAFT_DELAY);
}

/** Removes the stored text of the open script, and stores no other one. */
function forgetDraft() {
  clearTimeout(draftTimer);
  removeDraft(home.file, home.place);
}

/** Whether the open script is no longer in the scene, as after an undo that removes its object. */
let isGone = false;
/** Notes whether the open script is in the scene, and shows it. @param {boolean} isNowGone */
function setGone(isNowGone) {
  if (isNowGone === isGone) return;
  if (isNowGone) keepDraft();
  isGone = isNowGone;
  get("script-note").hidden = !isGone;
  for (const id of ["script-save", "script-run"]) get(id, HTMLButtonElement).disabled = isGone;
  showUnsaved();
}

/** Returns whether the text in the editor is not that of the script. */
function isChanged() {
  return rights.canControl && editorView !== null && shownScript !== 0 && editorView.state.doc.toString() !== saved.text;
}

/** Returns whether the editor has changes that can be saved. */
function isUnsaved() {
  return !isGone && isChanged();
}

/** Asks what to do with unsaved changes, if any. Returns a promise of whether the script may be closed. */
async function mayClose() {
  if (!isUnsaved() || !openedScript) return true;
  const chosen = await question(mark("Save the script?"), t`${openedScript.name} has changes that are not in the scene.`, [mark("Save"), mark("Discard"), mark("Cancel")]);
  if (chosen === "Save") return save();
  if (chosen !== "Discard") return false;
  saved.text = editorView?.state.doc.toString() ?? "";
  forgetDraft();
  showUnsaved();
  return true;
}
addUnsavedSource({ isUnsaved, save, mayClose });

/** Shows the name of a script, which is a path if the script is in a file: then the file name. @param {Script} script */
function showName(script) {
  const heading = get("script-name");
  heading.textContent = script.name.split(/[\\/]/).pop() ?? "";
  heading.title = script.name;
}

/**
 * Opens a script of the scene.
 * @param {Script} script
 */
export async function openScript(script) {
  if (openedScript?.id !== script.id && !(await mayClose())) return;
  openedScript = script;
  setGone(false);
  home = { file: scene.file, place: placeOf(script.id) };
  showName(script);
  get("script").hidden = false;
  if (!commands) send({ type: "commands" });
  send({ type: "script", script: script.id });
}

/** Handle of a new script that is opened as soon as the scene contains it; 0: none. */
let pendingScript = 0;

/** Returns all scripts of the scene. */
const allScripts = () => [...scene.scripts, ...[...scene.objects.values()].flatMap((o) => o.scripts ?? [])];

/** Opens the new script if the scene contains it. */
function openPending() {
  const found = pendingScript ? allScripts().find((s) => s.id === pendingScript) : undefined;
  if (!found) return;
  pendingScript = 0;
  openScript(found);
}

/**
 * Opens a script as soon as the scene contains it, which may be new.
 * @param {number} id
 */
export function openNewScript(id) {
  pendingScript = id;
  openPending();
}

on("commands", (message) => { commands = message.commands; });
on("script", ({ script, text: source, version }) => {
  if (openedScript?.id !== script) return;
  const text = withLineFeeds(source);
  const fieldText = editorView?.state.doc.toString();
  if (editorView && shownScript === script && fieldText !== saved.text) {
    // The editor has unsaved changes, which must not be replaced by the source that another client has saved.
    if (fieldText === text) {
      saved = { text, version };
      showUnsaved();
    } else if (version !== saved.version) writeLine("Status", t`${openedScript.name} was changed elsewhere: saving it will show both texts`, "warning");
    return;
  }
  saved = { text, version };
  if (shownScript === script && fieldText === text) return;
  shownScript = script;
  const draft = draftOf(home.file, home.place);
  if (draft === null || draft.text === text) fill(text);
  else offerDraft(draft, text);
});

/**
 * Asks whether to continue with a text that was never saved, and opens it or the text in the scene.
 * @param {{ text: string, time: number }} draft
 * @param {string} text
 */
async function offerDraft(draft, text) {
  const script = shownScript;
  const name = openedScript?.name || t`The script`;
  const explanation = t`${name} has a text of ${new Date(draft.time).toLocaleString(language)} that was not saved.`;
  const chosen = await question(mark("Continue with the unsaved text?"), explanation, [mark("Continue"), mark("Discard")]);
  if (shownScript !== script) return;
  if (chosen === "Discard") forgetDraft();
  fill(chosen === "Discard" ? text : draft.text);
}

/** Keeps the unsaved text of the open script, if any, and returns whether there is one. */
function keepDraft() {
  if (!isChanged() || !editorView) return false;
  storeDraft(home.file, home.place, editorView.state.doc.toString());
  return true;
}
addEventListener("pagehide", keepDraft);

// After a reconnection, and when a scene is opened again, such as by a recovery, the text in the editor is kept. Handles may
// have changed, so it is assigned to the script at the same place.
let isReconnected = false;
on("again", () => {
  isReconnected = true;
  commands = null;
});

/** Assigns the editor to the script at the same place of a new scene, or closes it and keeps its unsaved text. */
function followScene() {
  const found = isSameScene(scene.file, home.file) ? scriptAt(home.place) : undefined;
  if (found) {
    openedScript = found;
    setGone(false);
    if (shownScript) shownScript = found.id;
    send({ type: "script", script: found.id });
  } else {
    const name = openedScript?.name || t`the script`;
    if (keepDraft()) writeLine("Status", t`The unsaved text of ${name} is kept: open the script again to continue with it`, "warning");
    closeEditor();
  }
}

/** Requests the source of the open script again if the script has changed in the scene. */
function refreshScript() {
  if (openedScript) home = { file: scene.file, place: placeOf(openedScript.id) || home.place };
  const current = allScripts().find((s) => s.id === openedScript?.id);
  if (openedScript) setGone(!current);
  if (!current || current.version === openedScript?.version) return;
  openedScript = current;
  showName(current);
  send({ type: "script", script: current.id });
}
watch("objects", () => {
  refreshScript();
  openPending();
});
watch("scene", () => {
  if (scene.isNew) pendingScript = 0;
  if (openedScript && (scene.isNew || isReconnected)) {
    if (isReconnected) send({ type: "commands" });
    followScene();
  } else refreshScript();
  isReconnected = false;
  openPending();
});

/**
 * Marks the line that an error message such as "name:12: message" refers to, or the first line.
 * @param {string} text
 */
function markError(text) {
  if (!editorView) return;
  const match = text.match(/:(\d+):/);
  const n = match ? Math.min(Number(match[1]), editorView.state.doc.lines) : 1;
  codeFieldModule?.markLine(editorView, Math.max(1, n), text);
}

/** Saves the text to the scene. Returns a promise of whether the script in the scene is up to date. */
async function save() {
  if (!editorView || !openedScript || isGone || !rights.canControl) return false;
  codeFieldModule?.unmark(editorView);
  return saveSource(openedScript, editorView.state.doc.toString(), saved.version);
}

/**
 * Replaces the source of a script in the scene. If another client has saved a different source in the meantime, the
 * user chooses one of the two.
 * @param {Script} script
 * @param {string} text
 * @param {number} from version from which `text` was written
 * @param {boolean} [isMerged] whether `text` is not that of the editor, but one that the user has merged
 * @returns {Promise<boolean>}
 */
async function saveSource(script, text, from, isMerged = false) {
  try {
    const [{ version, theirs }] = await ask({ type: "save_script", script: script.id, text, version: from }, `saving ${script.name}`);
    if (theirs !== undefined) {
      const chosen = await resolveConflict(script.name, text, theirs);
      if (!chosen) return false;
      if (chosen.mine) return saveSource(script, chosen.text, version, true);
      saved = { text: withLineFeeds(chosen.text), version };
      forgetDraft();
      fill(chosen.text);
      return true;
    }
    saved = { text, version };
    // The user may have continued to write while the text was being saved.
    if (!keepDraft()) forgetDraft();
    showUnsaved();
    if (isMerged) fill(text);
    writeLine("Status", t`${script.name || t`The script`}: the new text is in the scene`);
    return true;
  } catch (thrown) {
    markError(failure(thrown).error);
    reportError(thrown);
    return false;
  }
}

/**
 * Returns the line of a script that an error refers to: its own, or, for an error in a module, that of the innermost call
 * from the script.
 * @param {Record<string, any>} payload of the event
 */
function lineInScript({ script, file, line, traceback }) {
  if (!file || file === script) return line;
  const frame = String(traceback ?? "").split("\n").find((call) => call.startsWith(`${script}:`));
  return frame ? Number(frame.slice(script.length + 1).match(/^\d+/)?.[0] ?? 0) : line;
}

on("event", ({ name, payload }) => {
  if (name !== "script_error" || !openedScript || !editorView || payload.script !== openedScript.name) return;
  const line = lineInScript(payload);
  if (line) markError(`${payload.script}:${line}: ${payload.message}`);
});
get("script-save").onclick = save;
get("script-run").onclick = async () => {
  if (await save() && editState.state !== "running") send({ type: "run", action: "start" });
};
// The script needs the width of the details, for lines of 80 characters.
const detailsButton = get("script-details");
detailsButton.onclick = () => {
  const isShown = get("script").classList.toggle("with-details");
  detailsButton.setAttribute("aria-pressed", String(isShown));
};

function closeEditor() {
  fillCount++;
  clearTimeout(draftTimer);
  get("script").hidden = true;
  openedScript = null;
  shownScript = 0;
  setGone(false);
  showUnsaved();
}
get("script-close").onclick = async () => { if (await mayClose()) closeEditor(); };
