// @ts-check
// The text field of the script editor, with syntax highlighting, completion and error markers. Its libraries are loaded
// when the first script is opened.

import { EditorState } from "@codemirror/state";
import { EditorView, keymap, lineNumbers, highlightActiveLine, drawSelection } from "@codemirror/view";
import { StreamLanguage, HighlightStyle, syntaxHighlighting, bracketMatching, indentOnInput } from "@codemirror/language";
import { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
import { autocompletion, completionKeymap } from "@codemirror/autocomplete";
import { lintGutter, setDiagnostics } from "@codemirror/lint";
import { lua } from "@codemirror/legacy-modes/mode/lua";
import { python } from "@codemirror/legacy-modes/mode/python";
import { tags } from "@lezer/highlight";

/** @import { CompletionContext, CompletionResult } from "@codemirror/autocomplete" */

const colors = HighlightStyle.define([
  { tag: tags.keyword, color: "var(--mark)", fontWeight: "600" },
  { tag: tags.comment, color: "var(--soft)", fontStyle: "italic" },
  { tag: tags.string, color: "light-dark(#0a7d3c, #7ee2a8)" },
  { tag: tags.number, color: "light-dark(#9a4a00, #ffb86b)" },
  { tag: tags.standard(tags.variableName), color: "light-dark(#6f42c1, #d2a8ff)" },
]);
const theme = EditorView.theme({
  "&": { backgroundColor: "var(--panel)", color: "var(--text)", fontSize: "13px" },
  ".cm-gutters": { backgroundColor: "var(--back)", color: "var(--soft)", border: "none" },
  ".cm-activeLine": { backgroundColor: "color-mix(in srgb, var(--mark) 9%, transparent)" },
  ".cm-cursor": { borderLeftColor: "var(--text)" },
  ".cm-tooltip": { backgroundColor: "var(--panel)", border: "1px solid var(--line)", maxWidth: "34rem" },
});

/**
 * Creates the text field of the script editor. It calls `changed` after each change of its text.
 * @param {{ parent: HTMLElement, text: string, complete: (context: CompletionContext) => CompletionResult | null, save: () => void, changed: () => void, readOnly: boolean, isPython: boolean }} what
 */
export function textField({ parent, text, complete, save, changed, readOnly, isPython }) {
  return new EditorView({
    parent,
    state: EditorState.create({
      doc: text,
      extensions: [
        lineNumbers(), history(), drawSelection(), EditorView.lineWrapping, highlightActiveLine(), bracketMatching(), indentOnInput(), lintGutter(),
        StreamLanguage.define(isPython ? python : lua), syntaxHighlighting(colors), theme, autocompletion({ override: [complete] }),
        keymap.of([{ key: "Mod-s", run: () => { save(); return true; } }, ...completionKeymap, ...historyKeymap, ...defaultKeymap, indentWithTab]),
        EditorView.updateListener.of(({ docChanged }) => { if (docChanged) changed(); }),
        EditorState.readOnly.of(readOnly), EditorView.contentAttributes.of({ "aria-label": "Script" }),
      ],
    }),
  });
}

/**
 * Marks a line with an error, instead of the line marked before.
 * @param {EditorView} view
 * @param {number} line counted from 1
 * @param {string} message
 */
export function markLine(view, line, message) {
  const { from, to } = view.state.doc.line(line);
  view.dispatch(setDiagnostics(view.state, [{ from, to, severity: "error", message }]));
}

/**
 * Removes all error markers.
 * @param {EditorView} view
 */
export function unmark(view) {
  view.dispatch(setDiagnostics(view.state, []));
}
