// @ts-check
// The script editor: opens, completes and saves scripts.

import { ask as question } from "tatu/lib/dialogs";
import { get } from "tatu/lib/dom";
import { failure } from "tatu/net/calls";
import { ask, on, send } from "tatu/net/connection";
import { line, tell } from "tatu/scene/messages";
import { rights, scene, watch } from "tatu/scene/store";
import { guard } from "tatu/documents/scene_file";
import { resolve } from "tatu/documents/version_conflict";

/** @import { CompletionContext } from "@codemirror/autocomplete" */
/** @import { EditorView } from "@codemirror/view" */
/** @import { Command, Script } from "tatu/protocol" */

/** @type {EditorView | null} */
let view = null;
/** The module that creates the text field, after it has been loaded. @type {typeof import("tatu/documents/code_field") | null} */
let tools = null;
/** The script that was opened. @type {Script | null} */
let open = null;
/** The source of the script in the scene when it was last opened or saved, and its version. */
let base = { text: "", version: 0 };
/** Handle of the script whose source is in the text field; 0: none. */
let shown = 0;
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

let filling = 0;
/** Creates the text field with a text. @param {string} text */
async function fill(text) {
  const own = ++filling;
  view?.destroy();
  view = null;
  const editing = await import("tatu/documents/code_field");
  // Another script may have been opened while the libraries were being loaded.
  if (own !== filling) return;
  tools = editing;
  view = editing.textField({ parent: get("editor"), text, complete, save: () => { save(); }, readOnly: !rights.acts });
  view.focus();
}

/** Returns whether the editor has unsaved changes. */
function isUnsaved() {
  return rights.acts && view !== null && shown !== 0 && view.state.doc.toString() !== base.text;
}

/** Asks what to do with unsaved changes, if any. Returns a promise of whether the script may be closed. */
async function mayLeave() {
  if (!isUnsaved() || !open) return true;
  const chosen = await question("Save the script?", `${open.name} has changes that are not in the scene.`, ["Save", "Discard", "Cancel"]);
  if (chosen === "Save") return save();
  if (chosen !== "Discard") return false;
  base.text = view?.state.doc.toString() ?? "";
  return true;
}
guard(isUnsaved, mayLeave);

/**
 * Opens a script of the scene.
 * @param {Script} script
 */
export async function openScript(script) {
  if (open?.id !== script.id && !(await mayLeave())) return;
  open = script;
  get("script-name").textContent = script.name;
  get("script").hidden = false;
  if (!commands) send({ type: "commands" });
  send({ type: "script", script: script.id });
}

on("commands", (message) => { commands = message.commands; });
on("script", ({ script, text, version }) => {
  if (open?.id !== script) return;
  const own = view?.state.doc.toString();
  if (view && shown === script && own !== base.text) {
    // The editor has unsaved changes, which must not be replaced by the source that another client has saved.
    if (own === text) base = { text, version };
    else if (version !== base.version) line("Status", `${open.name} was changed elsewhere: saving it will show both texts`, "warning");
    return;
  }
  base = { text, version };
  if (shown === script && own === text) return;
  shown = script;
  fill(text);
});

// After a reconnection, the text in the editor is kept. It is assigned to the script with the same name, because
// handles may have changed.
let again = false;
on("again", () => {
  again = true;
  commands = null;
});

/** Requests the source of the open script again if the script has changed in the scene. */
function follow() {
  const all = [...scene.scripts, ...[...scene.objects.values()].flatMap((o) => o.scripts ?? [])];
  if (again && open) {
    const name = open.name;
    const same = all.filter((s) => s.name === name);
    open = same.find((s) => s.id === open?.id) ?? same[0] ?? open;
    if (shown) shown = open.id;
    else send({ type: "script", script: open.id });
    send({ type: "commands" });
  }
  again = false;
  const now = all.find((s) => s.id === open?.id);
  if (!now || now.version === open?.version) return;
  open = now;
  send({ type: "script", script: now.id });
}
watch("objects", follow);
watch("scene", () => {
  if (scene.another && !again && open) close();
  follow();
});

/**
 * Marks the line that an error message such as "name:12: message" refers to, or the first line.
 * @param {string} text
 */
function mark(text) {
  if (!view) return;
  const at = text.match(/:(\d+):/);
  const n = at ? Math.min(Number(at[1]), view.state.doc.lines) : 1;
  tools?.markLine(view, Math.max(1, n), text);
}

/** Saves the text to the scene. Returns a promise of whether the script in the scene is up to date. */
async function save() {
  if (!view || !open || !rights.acts) return false;
  tools?.unmark(view);
  return put(open, view.state.doc.toString(), base.version);
}

/**
 * Replaces the source of a script in the scene. If another client has saved a different source in the meantime, the
 * user chooses one of the two.
 * @param {Script} script
 * @param {string} text
 * @param {number} from version from which `text` was written
 * @returns {Promise<boolean>}
 */
async function put(script, text, from) {
  try {
    const [{ version, theirs }] = await ask({ type: "save_script", script: script.id, text, version: from }, `saving ${script.name}`);
    if (theirs !== undefined) {
      const chosen = await resolve(script.name, text, theirs);
      if (!chosen) return false;
      if (chosen.mine) return put(script, chosen.text, version);
      base = { text: chosen.text, version };
      fill(chosen.text);
      return true;
    }
    base = { text, version };
    if (view?.state.doc.toString() !== text) fill(text);
    line("Status", `${script.name || "Script"}: the new text is in the scene`);
    return true;
  } catch (thrown) {
    mark(failure(thrown).error);
    tell(thrown);
    return false;
  }
}

on("event", ({ name, payload }) => {
  if (name === "script_error" && open && view && payload.script === open.name && payload.line) {
    mark(`${payload.script}:${payload.line}: ${payload.message}`);
  }
});
get("script-save").onclick = save;

function close() {
  filling++;
  get("script").hidden = true;
  open = null;
  shown = 0;
}
get("script-close").onclick = async () => { if (await mayLeave()) close(); };
