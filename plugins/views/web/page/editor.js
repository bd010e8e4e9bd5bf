// @ts-check
// The script editor: Lua in colours, commands completed and explained, errors at their line.

import { EditorState } from "@codemirror/state";
import { EditorView, keymap, lineNumbers, highlightActiveLine, drawSelection } from "@codemirror/view";
import { StreamLanguage, HighlightStyle, syntaxHighlighting, bracketMatching, indentOnInput } from "@codemirror/language";
import { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
import { autocompletion, completionKeymap } from "@codemirror/autocomplete";
import { lintGutter, setDiagnostics } from "@codemirror/lint";
import { lua } from "@codemirror/legacy-modes/mode/lua";
import { tags } from "@lezer/highlight";
import { failure } from "tatu/calls";
import { get } from "tatu/dom";
import { call, on, send } from "tatu/net";
import { changed, rights, scene, watch } from "tatu/store";
import { line } from "tatu/output";

/** @import { CompletionContext } from "@codemirror/autocomplete" */
/** @import { Command, Script } from "tatu/protocol" */

/** @type {EditorView | null} */
let view = null;
/** @type {Script | null} */
let open = null;
/** The text of the open script as the scene had it last. */
let known = "";
/** The script whose text the editor holds. */
let shown = 0;
/** @type {Command[] | null} */
let commands = null;

const colours = HighlightStyle.define([
  { tag: tags.keyword, color: "var(--mark)", fontWeight: "600" },
  { tag: tags.comment, color: "var(--soft)", fontStyle: "italic" },
  { tag: tags.string, color: "light-dark(#0a7d3c, #7ee2a8)" },
  { tag: tags.number, color: "light-dark(#9a4a00, #ffb86b)" },
  { tag: tags.standard(tags.variableName), color: "light-dark(#6f42c1, #d2a8ff)" },
]);
const look = EditorView.theme({
  "&": { backgroundColor: "var(--panel)", color: "var(--text)", fontSize: "13px" },
  ".cm-gutters": { backgroundColor: "var(--back)", color: "var(--soft)", border: "none" },
  ".cm-activeLine": { backgroundColor: "color-mix(in srgb, var(--mark) 9%, transparent)" },
  ".cm-cursor": { borderLeftColor: "var(--text)" },
  ".cm-tooltip": { backgroundColor: "var(--panel)", border: "1px solid var(--line)", maxWidth: "34rem" },
});

/** @param {CompletionContext} context */
function complete(context) {
  const word = context.matchBefore(/[\w.]+/);
  if (!word || (word.from === word.to && !context.explicit)) return null;
  return {
    from: word.from,
    options: (commands ?? []).map(({ name, params, text }) => ({ label: name, detail: `(${params})`, info: text, type: "function" })),
    validFor: /^[\w.]*$/,
  };
}

/** @param {string} text */
function fill(text) {
  view?.destroy();
  view = new EditorView({
    parent: get("editor"),
    state: EditorState.create({
      doc: text,
      extensions: [
        lineNumbers(), history(), drawSelection(), highlightActiveLine(), bracketMatching(), indentOnInput(), lintGutter(),
        StreamLanguage.define(lua), syntaxHighlighting(colours), look, autocompletion({ override: [complete] }),
        keymap.of([{ key: "Mod-s", run: () => { save(); return true; } }, ...completionKeymap, ...historyKeymap, ...defaultKeymap, indentWithTab]),
        EditorState.readOnly.of(!rights.acts), EditorView.contentAttributes.of({ "aria-label": "Script" }),
      ],
    }),
  });
  view.focus();
}

/**
 * Opens a script of the scene.
 * @param {Script} script
 */
export function openScript(script) {
  open = script;
  get("script-name").textContent = script.name;
  get("script").hidden = false;
  if (!commands) send({ type: "commands" });
  send({ type: "script", script: script.id });
}

on("commands", (message) => { commands = message.commands; });
on("script", ({ script, text }) => {
  if (open?.id !== script) return;
  // A text that another client has saved does not replace what is being written here.
  const own = view?.state.doc.toString();
  const isNew = shown !== script || (own === known && own !== text);
  known = text;
  shown = script;
  if (isNew) fill(text);
});

// After a lost connection the text in the editor remains, and belongs to the script of the same name.
let again = false;
on("again", () => {
  again = true;
  commands = null;
});

/** Asks for the text of the open script again if it has changed. */
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
watch("scene", follow);

/**
 * Marks a line that a message names: "name:12: what is wrong".
 * @param {string} text
 */
function mark(text) {
  if (!view) return;
  const at = text.match(/:(\d+):/);
  const n = at ? Math.min(Number(at[1]), view.state.doc.lines) : 1;
  const { from, to } = view.state.doc.line(Math.max(1, n));
  view.dispatch(setDiagnostics(view.state, [{ from, to, severity: "error", message: text }]));
}

async function save() {
  if (!view || !open || !rights.acts) return;
  view.dispatch(setDiagnostics(view.state, []));
  try {
    const text = view.state.doc.toString();
    await call("tatu.setScript", open.id, text);
    known = text;
    changed();
    line("Status", `${open.name}: the new text is in the scene`);
  } catch (thrown) {
    const e = failure(thrown);
    mark(e.error);
    line("Status", e.error, "error");
  }
}

on("event", ({ name, payload }) => {
  if (name === "script_error" && open && view && payload.script === open.name && payload.line) {
    mark(`${payload.script}:${payload.line}: ${payload.message}`);
  }
});
get("script-save").onclick = save;
get("script-close").onclick = () => { get("script").hidden = true; open = null; shown = 0; };
