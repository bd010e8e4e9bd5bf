// @ts-check
// The button that records films. A recording starts at the next start of the simulation, or immediately during a run,
// and ends when the simulation is stopped; then the browser saves the film as a page.

import { get } from "tatu/lib/dom";
import { download } from "tatu/lib/download";
import { t } from "tatu/lib/language";
import { ask, on } from "tatu/net/connection";
import { editState } from "tatu/scene/edits";
import { reportError, writeLine } from "tatu/scene/messages";
import { rights, scene, watch } from "tatu/scene/store";

const button = get("film", HTMLButtonElement);
/** Whether the user has requested a film. */
let isRequested = false;
/** Whether each run is filmed, as exercises require. */
let filmsAlways = false;
/** The film of the last run. @type {Blob | null} */
let lastRecorded = null;

function updateButton() {
  button.disabled = !rights.canControl;
  button.setAttribute("aria-pressed", String(isRequested));
  button.title = isRequested ? t`Recording a film: it is saved when the simulation stops or at a click` : t`Record the run as a page that plays it without the program`;
}

function begin() {
  return ask({ type: "film", on: true }, "filming").catch(reportError);
}

/** Ends a recording. Returns a promise of the film, or of null if the simulation has not run. */
async function end() {
  try {
    const [page, endTime] = await ask({ type: "film", on: false }, "the film");
    if (typeof endTime === "number") writeLine("Status", t`The film ends at ${endTime.toFixed(1)} s, because it became too large`, "warning");
    if (typeof page !== "string") return null;
    return new Blob([Uint8Array.from(atob(page), (c) => c.charCodeAt(0))], { type: "text/html" });
  } catch (thrown) {
    reportError(thrown);
    return null;
  }
}

/** Returns the name of the scene's file without its extension, followed by `ending`. @param {string} ending */
export function fileNameFor(ending) {
  const name = editState.file.split(/[\\/]/).pop()?.replace(/\.\w+$/, "") || "scene";
  return `${name}${ending}`;
}

/**
 * Sets whether each run is filmed from now on. `lastFilm` returns the film of the last run.
 * @param {boolean} isOn
 */
export function setFilmAlways(isOn) {
  if (filmsAlways === isOn || !rights.canControl) return;
  filmsAlways = isOn;
  if (filmsAlways) begin();
  else if (!isRequested) end();
}

/** Settled when the film that ended last has been received. */
let finishing = Promise.resolve();

/** Returns a promise of the film that was recorded last in this scene, or of null if there is none. */
export async function lastFilm() {
  await finishing;
  return lastRecorded;
}

/** Ends the recording when the simulation has stopped, and saves the film if the user has requested it. */
async function finish() {
  const film = await end();
  if (film) lastRecorded = film;
  if (isRequested) {
    isRequested = false;
    updateButton();
    if (film) {
      download(film, fileNameFor(".html"));
      writeLine("Status", t`The film ${fileNameFor(".html")} has ${(film.size / 1e6).toFixed(1)} MB; any browser shows it`);
    } else writeLine("Status", t`There is no film, because the simulation has not run`, "warning");
  }
  if (filmsAlways) await begin();
}

button.onclick = async () => {
  if (isRequested && editState.state !== "stopped") {
    finishing = finish();
    return;
  }
  isRequested = !isRequested;
  updateButton();
  if (filmsAlways) return;
  if (isRequested) await begin();
  else await end();
};
on("event", ({ name }) => { if (name === "stopped" && (isRequested || filmsAlways)) finishing = finish(); });
watch("scene", () => { if (scene.isNew) lastRecorded = null; });
// The program ends the recording when the connection is lost.
on("again", () => {
  isRequested = false;
  updateButton();
  if (filmsAlways) begin();
});
on("hello", updateButton);
