// @ts-check
// What the panel of details shows while nothing is selected: what the scene is about, its scripts, and keys.

import { get, make } from "tatu/lib/dom";
import { inlineNodes } from "tatu/lib/inline_text";
import { language, LANGUAGES, setLanguage, t } from "tatu/lib/language";
import { scene, selected, watch } from "tatu/scene/store";
import { openScript } from "tatu/documents/script_editor";

const panel = get("about-scene");
/** Maximum number of scripts that are listed. */
const MAX_SCRIPTS = 12;
/** Keys and mouse actions, and their effects. @type {[string, string][]} */
const HINTS = [
  ["F5", t`play or pause`], ["F6", t`one step`], ["F7", t`stop and reset`], ["F", t`see everything`],
  [t`Drag, right drag, wheel`, t`turn, pan, zoom`], [t`Click, click again`, t`select a model, its part`], ["G, R", t`move, turn the selection`],
  [t`Shift and drag`, t`push a body during a run`], ["Ctrl+Z, Ctrl+S", t`undo, save`],
];

/**
 * Returns a list of terms with their descriptions.
 * @param {[string | Node, string | Node][]} entries
 * @param {string} className
 */
function definitions(entries, className) {
  const list = make("dl", { className });
  for (const [term, description] of entries) {
    const [dt, dd] = [make("dt"), make("dd")];
    dt.append(term);
    dd.append(description);
    list.append(dt, dd);
  }
  return list;
}

/** Returns the scripts of the scene as links, each with the name of its object. */
function scriptLinks() {
  const objects = [...scene.objects.values()].flatMap((o) => (o.scripts ?? []).map((script) => ({ script, name: o.alias })));
  const all = [...scene.scripts.map((script) => ({ script, name: t`the scene` })), ...objects];
  const list = make("ul");
  for (const { script, name } of all.slice(0, MAX_SCRIPTS)) {
    const link = make("button", { type: "button", className: "link", textContent: name, title: t`Open ${script.name}`, onclick: () => openScript(script) });
    const item = make("li");
    item.append(link);
    list.append(item);
  }
  if (all.length > MAX_SCRIPTS) list.append(make("li", { textContent: t`and ${all.length - MAX_SCRIPTS} more` }));
  return all.length ? list : t`none`;
}

/** Returns the field that chooses the language of the page. */
function languageField() {
  const field = make("label", { className: "language", textContent: `${t`Language`} ` });
  const choice = make("select", { onchange: () => setLanguage(choice.value) });
  choice.append(...Object.entries(LANGUAGES).map(([tag, name]) => make("option", { value: tag, textContent: name, lang: tag, selected: tag === language })));
  field.append(choice);
  return field;
}

let shown = "";
/** Shows the scene if nothing is selected. */
function show() {
  panel.hidden = selected() !== 0 || !scene.file;
  if (panel.hidden) return;
  const all = [...scene.objects.values()];
  const state = JSON.stringify([scene.about, scene.suggestion, scene.dt, all.length, scene.scripts, all.map((o) => [o.alias, o.scripts])]);
  if (state === shown) return;
  shown = state;
  const models = all.filter((o) => o.model).length;
  const objects = !models ? `${all.length}` : models > 1 ? t`${all.length}, in ${models} models` : t`${all.length}, in one model`;
  const suggestion = make("p", { className: "suggestion", hidden: !scene.suggestion });
  suggestion.append(make("strong", { textContent: `${t`Try:`} ` }), ...inlineNodes(scene.suggestion));
  const about = make("p", { hidden: !scene.about });
  about.append(...inlineNodes(scene.about));
  panel.replaceChildren(
    about, suggestion,
    definitions([[t`Objects`, objects], [t`Time step`, `${+(scene.dt * 1000).toFixed(3)} ms`], [t`Scripts`, scriptLinks()]], "facts"),
    make("h3", { textContent: t`Keys and mouse` }), definitions(HINTS.map(([keys, effect]) => [make("kbd", { textContent: keys }), effect]), "hints"),
    languageField(),
  );
}
for (const change of /** @type {const} */ (["scene", "objects", "selected"])) watch(change, show);
show();
