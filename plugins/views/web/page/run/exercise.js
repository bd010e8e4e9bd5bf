// @ts-check
// Exercises: a task with goals that a teacher adds to a scene, limits on what students may change, and the file that
// they hand in.

import { choose } from "tatu/lib/dialogs";
import { get, make } from "tatu/lib/dom";
import { download } from "tatu/lib/download";
import { openFloatingWindow } from "tatu/lib/floating_window";
import { inlineNodes } from "tatu/lib/inline_text";
import { mark, t } from "tatu/lib/language";
import { pack } from "tatu/lib/zip";
import { call, on, send } from "tatu/net/connection";
import { edit, editState, isScriptsOnly, setScriptsOnly } from "tatu/scene/edits";
import { reportError, writeLine } from "tatu/scene/messages";
import { rights, scene, watch } from "tatu/scene/store";
import { saveTexts } from "tatu/documents/scene_file";
import { openScript } from "tatu/documents/script_editor";
import { isWindowOpen, openWindow, registerWindow, windowClosed } from "tatu/windows/open_windows";
import { fileNameFor, lastFilm, setFilmAlways } from "tatu/run/film_recorder";

/** @import { Script } from "tatu/protocol" */
/** @typedef {{ text: string, state: "open" | "reached" | "failed", time: number }} Goal */
/** @typedef {{ object: number, task: string, goals: string, change: string }} Exercise */

/** Pattern of the name of the object that contains an exercise. */
const ALIAS = /^Exercise\d*$/;
/** Tags of the custom data of that object. */
const TAGS = /** @type {const} */ ({ task: "exercise.task", goals: "exercise.goals", change: "exercise.change" });
const MARKS = { open: "\u25CB", reached: "\u2713", failed: "\u2717" };

/** @type {Exercise | null} */
let exercise = null;
/** @type {Goal[]} */
let goals = [];
/** Whether the limits of this exercise were lifted in order to edit it. */
let areLimitsLifted = false;
/** @type {(() => void) | null} */
let refresh = null;

/** Returns the goals before a run. The text of each is the part of its line before the last colon, or the whole line. */
function plannedGoals() {
  const lines = (exercise?.goals ?? "").split(/\r?\n/).map((l) => l.trim()).filter(Boolean);
  return lines.map((l) => ({ text: l.match(/^(.*):\s/)?.[1] ?? l, state: /** @type {const} */ ("open"), time: -1 }));
}

function applyLimits() {
  setScriptsOnly(exercise?.change === "scripts" && !areLimitsLifted);
  for (const id of ["add", "move", "turn"]) get(id, HTMLButtonElement).disabled = isScriptsOnly();
  setFilmAlways(exercise !== null && exercise.change === "scripts" && !areLimitsLifted);
  refresh?.();
}

function openExercise() {
  const window = openFloatingWindow({ key: "exercise", title: t`Exercise`, width: 340, height: 300, closed });
  const opened = { kind: "exercise", spec: {}, close: window.close };
  const task = make("div", { className: "task" });
  const list = make("ul", { className: "goals" });
  list.setAttribute("aria-label", t`Goals`);
  list.setAttribute("aria-live", "polite");
  const row = make("div", { className: "tools" });
  const handInButton = make("button", { type: "button", textContent: t`Hand in`, title: t`Save the scripts, the film of the last run and its goals in one file`, onclick: handIn });
  const changeButton = make("button", { type: "button", textContent: t`Edit`, title: t`Write the task and its goals`, onclick: editExercise });
  const note = make("p", { className: "note" });
  const scriptButton = make("button", { type: "button", textContent: t`Open the script`, title: t`Open the script that the exercise is about`, onclick: openFirstScript });
  row.append(scriptButton, handInButton, changeButton);
  window.body.append(task, list, note, row);
  refresh = () => {
    task.replaceChildren(...(exercise?.task ?? "").split(/\n\s*\n/).map((text) => {
      const paragraph = make("p");
      paragraph.append(...inlineNodes(text.replaceAll("\n", " ")));
      return paragraph;
    }));
    list.replaceChildren(...(goals.length ? goals : plannedGoals()).map(({ text, state, time }) => {
      const item = make("li", { className: state });
      const mark = make("span", { className: "mark", textContent: MARKS[state] });
      mark.setAttribute("role", "img");
      mark.setAttribute("aria-label", state);
      item.append(mark, make("span", { textContent: text }), make("small", { textContent: time >= 0 ? `${time.toFixed(2)} s` : "" }));
      return item;
    }));
    note.textContent = isScriptsOnly() ? t`Only scripts can be changed in this exercise.` : "";
    scriptButton.hidden = scripts().length === 0;
    handInButton.disabled = changeButton.disabled = !rights.canControl;
  };
  function closed() {
    refresh = null;
    windowClosed(opened);
  }
  refresh();
  return opened;
}
registerWindow("exercise", openExercise);

/** Opens the exercise of the scene, or the form for a new one. */
export function showExercise() {
  if (exercise) openWindow("exercise", {});
  else editExercise();
}

/**
 * Returns a string as a literal for a scene file.
 * @param {string} text
 */
const tomlString = (text) => JSON.stringify(text).replace(/\u007f/g, "\\u007f");

async function editExercise() {
  if (isScriptsOnly()) {
    const confirmed = await choose(mark("Change the exercise?"), [make("p", { textContent: t`Everything in the scene can be changed until it is opened again. The file to hand in will record this.` })], [mark("Change it"), mark("Cancel")]);
    if (confirmed !== "Change it") return;
    areLimitsLifted = true;
    applyLimits();
  }
  const task = make("textarea", { rows: 6, value: exercise?.task ?? "" });
  const lines = make("textarea", { rows: 5, value: exercise?.goals ?? "", spellcheck: false });
  const changeSelect = make("select");
  changeSelect.add(new Option(t`scripts only`, "scripts"));
  changeSelect.add(new Option(t`everything`, "everything"));
  changeSelect.value = exercise?.change ?? "scripts";
  const field = (/** @type {string} */ name, /** @type {HTMLElement} */ input) => {
    const label = make("label", { className: "field" });
    label.append(make("span", { textContent: name }), input);
    return label;
  };
  const help = make("p", { className: "note", textContent: t`Examples: Reach the flag: /Robot within 0.3 m of /Flag before 30 s \u00B7 never /Robot touches /Wall if goal 1 \u00B7 never /Robot jumps \u00B7 /Robot goes 5 m \u00B7 /Pole object.position.z > 0.8 for 5 s` });
  const content = [field(t`Task`, task), field(t`Goals, one in a line`, lines), help, field(t`Students may change`, changeSelect)];
  const chosen = await choose(mark("Exercise"), content, [mark("Take into the scene"), mark("Cancel")], () => task.focus());
  if (chosen !== "Take into the scene") return;
  const data = { [TAGS.task]: task.value.trim(), [TAGS.goals]: lines.value.trim(), [TAGS.change]: changeSelect.value };
  // The author continues to edit the scene, so the limits apply only when the scene is opened again.
  areLimitsLifted = true;
  try {
    if (exercise) {
      // Other custom data of the object is retained.
      const [previous] = await call("tatu.get", exercise.object, "object.data");
      await edit(t`Change exercise`, [["tatu.set", exercise.object, "object.data", { ...previous, ...data }]]);
    } else {
      const script = await (await fetch("/page/run/exercise.lua")).text();
      const entries = Object.entries(data).map(([tag, text]) => `${tomlString(tag)} = ${tomlString(text)}`).join(", ");
      const text = `format = 1\n[[object]]\nkind = "dummy"\nalias = "Exercise"\ndata = { ${entries} }\nscript = { text = ${tomlString(script)} }\n`;
      await edit(t`Add exercise`, [["tatu.add", text]]);
    }
    // The program does not send a message when custom data has changed.
    requestExercise();
  } catch (thrown) {
    reportError(thrown);
  }
}

/** Requests the exercise of the scene, if there is one. */
function requestExercise() {
  const exerciseObject = [...scene.objects.values()].find((o) => ALIAS.test(o.alias));
  if (exerciseObject) send({ type: "data", object: exerciseObject.id });
  else setExercise(null);
}

/** @param {Exercise | null} found */
function setExercise(found) {
  const previous = exercise;
  exercise = found;
  if (JSON.stringify(found) !== JSON.stringify(previous)) goals = [];
  applyLimits();
  if (found && !previous && !isWindowOpen("exercise", {})) openWindow("exercise", {});
}

on("data", ({ object, data }) => {
  const exerciseObject = scene.objects.get(object);
  if (!exerciseObject || !ALIAS.test(exerciseObject.alias)) return;
  const [task, lines, change] = [data[TAGS.task] ?? "", data[TAGS.goals] ?? "", data[TAGS.change] ?? ""];
  setExercise(task || lines ? { object, task, goals: lines, change } : null);
});
watch("scene", () => {
  if (scene.isNew) {
    areLimitsLifted = false;
    exercise = null;
    goals = [];
  }
  requestExercise();
});
/** The versions of the scripts at the end of the last run, by handle. @type {Map<number, number>} */
let versionsInRun = new Map();
on("event", ({ name, payload }) => {
  if (name === "exercise.goals") {
    goals = Object.values(payload.goals ?? []);
    refresh?.();
  } else if (name === "stopped") versionsInRun = new Map(scripts().map(({ id, version }) => [id, version]));
  else if (name === "edited") requestExercise();
});

/** @typedef {{ text: string, version: number }} Source */
/** Callbacks of pending requests for script sources, by script. @type {Map<number, (source: Source) => void>} */
const textRequests = new Map();
on("script", ({ script, text, version }) => {
  textRequests.get(script)?.({ text, version });
  textRequests.delete(script);
});

/**
 * Requests the source of a script and its version.
 * @param {Script} script
 * @returns {Promise<Source>}
 */
function sourceOf(script) {
  return new Promise((resolve) => {
    textRequests.set(script.id, resolve);
    send({ type: "script", script: script.id });
  });
}

/** Returns all scripts of the scene and of its objects, except that of the exercise. */
function scripts() {
  const objects = [...scene.objects.values()].filter((o) => o.id !== exercise?.object);
  return [...scene.scripts, ...objects.flatMap((o) => o.scripts ?? [])];
}

/** Opens the first script of the scene that is not that of the exercise. */
function openFirstScript() {
  const [first] = scripts();
  if (first) openScript(first);
}

const NAME_KEY = "tatu student";
/** Asks for the name of the student. Returns a promise of the name, or of null if the student cancels. */
async function askName() {
  const input = make("input", { type: "text", className: "wide", value: localStorage.getItem(NAME_KEY) ?? "", maxLength: 80, autocomplete: "name" });
  input.setAttribute("aria-label", t`Your name`);
  const explanation = make("p", { textContent: t`The file to hand in contains your name, the scripts, the film of the last run and its goals.` });
  const chosen = await choose(mark("Your name"), [explanation, input], [mark("Hand in"), mark("Cancel")], () => input.focus());
  if (chosen !== "Hand in") return null;
  localStorage.setItem(NAME_KEY, input.value.trim());
  return input.value.trim();
}

/** Returns a text as a part of a file name. @param {string} text */
const fileNamePart = (text) => text.replace(/[^\p{L}\p{N}._-]+/gu, "_").replace(/^[_.]+|[_.]+$/g, "");

/** Saves a student's work as a zip file with the scripts, and the film and goals of the last run. */
async function handIn() {
  if (!(await saveTexts())) {
    writeLine("Status", t`Not handed in, because the new text of the script is not in the scene`, "warning");
    return;
  }
  const film = editState.state === "stopped" ? await lastFilm() : null;
  if (!film) {
    writeLine("Status", t`There is nothing to hand in yet: run the simulation, and stop it, first`, "warning");
    return;
  }
  const student = await askName();
  if (student === null) return;
  try {
    const encoder = new TextEncoder();
    /** @type {{ name: string, bytes: Uint8Array<ArrayBuffer> }[]} */
    const files = [];
    /** @type {{ [file: string]: string }} */
    const list = {};
    /** @type {string[]} */
    const changed = [];
    for (const script of scripts()) {
      const baseName = fileNamePart(script.name || script.kind).replace(/\.(lua|py)$/, "") || "script";
      const ending = script.language === "python" ? "py" : "lua";
      const name = [baseName, ...Array.from({ length: 99 }, (_, i) => `${baseName}_${i + 2}`)].map((n) => `scripts/${n}.${ending}`).find((n) => !list[n]) ?? "";
      list[name] = script.name;
      const { text, version } = await sourceOf(script);
      if (versionsInRun.get(script.id) !== version) changed.push(script.name);
      files.push({ name, bytes: encoder.encode(text) });
    }
    const decided = goals.map((goal) => ({ ...goal, time: Number(goal.time.toFixed(6)) }));
    const summary = { student, scene: scene.file.split(/[\\/]/).pop(), when: new Date().toISOString(), changed: areLimitsLifted ? "everything" : "scripts", goals: decided, scripts: list };
    files.unshift({ name: "exercise.json", bytes: encoder.encode(`${JSON.stringify(summary, null, 2)}\n`) });
    files.push({ name: "film.html", bytes: new Uint8Array(await film.arrayBuffer()) });
    const name = fileNameFor(`_handed_in${student ? `_${fileNamePart(student)}` : ""}.zip`);
    download(new Blob([pack(files)], { type: "application/zip" }), name);
    writeLine("Status", t`${name} is in the downloads of your browser: give it to your teacher`);
    if (changed.length) writeLine("Status", t`The film in ${name} is older than the text of ${changed.join(", ")}: run the scene again and hand in again`, "warning");
  } catch (thrown) {
    reportError(thrown);
  }
}

get("exercise").onclick = showExercise;
