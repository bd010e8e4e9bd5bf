// @ts-check
// The button that records films. A recording starts at the next start of the simulation, or immediately during a run,
// and ends when the simulation is stopped; then the browser saves the film as a page.

import { get } from "tatu/lib/dom";
import { download } from "tatu/lib/download";
import { ask, on } from "tatu/net/connection";
import { known } from "tatu/scene/edits";
import { line, tell } from "tatu/scene/messages";
import { rights, scene, watch } from "tatu/scene/store";

const button = get("film", HTMLButtonElement);
/** Whether the user has requested a film. */
let filming = false;
/** Whether each run is filmed, as exercises require. */
let always = false;
/** The film of the last run. @type {Blob | null} */
let last = null;

function mark() {
  button.disabled = !rights.acts;
  button.setAttribute("aria-pressed", String(filming));
  button.title = filming ? "Recording a film: it is saved when the simulation stops or at a click" : "Record the run as a page that plays it without the program";
}

function begin() {
  return ask({ type: "film", on: true }, "filming").catch(tell);
}

/** Ends a recording. Returns a promise of the film, or of null if the simulation has not run. */
async function end() {
  try {
    const [page, full] = await ask({ type: "film", on: false }, "the film");
    if (typeof full === "number") line("Status", `The film ends at ${full.toFixed(1)} s, because it became too large`, "warning");
    if (typeof page !== "string") return null;
    return new Blob([Uint8Array.from(atob(page), (c) => c.charCodeAt(0))], { type: "text/html" });
  } catch (thrown) {
    tell(thrown);
    return null;
  }
}

/** Returns the name of the scene's file without its extension, followed by `ending`. @param {string} ending */
export function nameFor(ending) {
  const name = known.file.split(/[\\/]/).pop()?.replace(/\.\w+$/, "") || "scene";
  return `${name}${ending}`;
}

/**
 * Sets whether each run is filmed from now on. `lastFilm` returns the film of the last run.
 * @param {boolean} is
 */
export function filmAlways(is) {
  if (always === is || !rights.acts) return;
  always = is;
  if (always) begin();
  else if (!filming) end();
}

/** Settled when the film that ended last has been received. */
let finishing = Promise.resolve();

/** Returns a promise of the film that was recorded last in this scene, or of null if there is none. */
export async function lastFilm() {
  await finishing;
  return last;
}

/** Ends the recording when the simulation has stopped, and saves the film if the user has requested it. */
async function finish() {
  const film = await end();
  if (film) last = film;
  if (filming) {
    filming = false;
    mark();
    if (film) {
      download(film, nameFor(".html"));
      line("Status", `The film ${nameFor(".html")} has ${(film.size / 1e6).toFixed(1)} MB; any browser shows it`);
    } else line("Status", "There is no film, because the simulation has not run", "warning");
  }
  if (always) await begin();
}

button.onclick = async () => {
  if (filming && known.state !== "stopped") {
    finishing = finish();
    return;
  }
  filming = !filming;
  mark();
  if (always) return;
  if (filming) await begin();
  else await end();
};
on("event", ({ name }) => { if (name === "stopped" && (filming || always)) finishing = finish(); });
watch("scene", () => { if (scene.another) last = null; });
// The program ends the recording when the connection is lost.
on("again", () => {
  filming = false;
  mark();
  if (always) begin();
});
on("hello", mark);
