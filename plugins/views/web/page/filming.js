// @ts-check
// The button for films: records from the next start, or during a run from now on, until the stop; then the browser
// saves the film as a page.

import { get } from "tatu/dom";
import { known } from "tatu/edits";
import { ask, on } from "tatu/net";
import { line, tell } from "tatu/output";
import { rights, scene, watch } from "tatu/store";
import { download } from "tatu/table";

const button = get("film", HTMLButtonElement);
let filming = false;
/** Whether each run is filmed, as exercises require, and the film of the last run. */
let always = false;
/** @type {Blob | null} */
let last = null;

function mark() {
  button.disabled = !rights.acts;
  button.setAttribute("aria-pressed", String(filming));
  button.title = filming ? "Filming: the stop, or a click, saves the film" : "Film the run, as a page that shows it without the program";
}

function begin() {
  return ask({ type: "film", on: true }, "filming").catch(tell);
}

/** Ends a recording; returns a promise of the film, or of null if nothing ran. */
async function end() {
  try {
    const [page, full] = await ask({ type: "film", on: false }, "the film");
    if (typeof full === "number") line("Status", `The film ends at ${full.toFixed(1)} s: it became too large`, "warning");
    if (typeof page !== "string") return null;
    return new Blob([Uint8Array.from(atob(page), (c) => c.charCodeAt(0))], { type: "text/html" });
  } catch (thrown) {
    tell(thrown);
    return null;
  }
}

/** Returns a file name based on that of the scene. @param {string} ending */
export function nameFor(ending) {
  const name = known.file.split(/[\\/]/).pop()?.replace(/\.\w+$/, "") || "scene";
  return `${name}${ending}`;
}

/**
 * Sets whether each run is filmed from now on, for `lastFilm`.
 * @param {boolean} is
 */
export function filmAlways(is) {
  if (always === is || !rights.acts) return;
  always = is;
  if (always) begin();
  else if (!filming) end();
}

/** Settled when the film that has just ended has been processed. */
let finishing = Promise.resolve();

/** Returns a promise of the film of the last run if each run is filmed, or of null if there is none. */
export async function lastFilm() {
  await finishing;
  return last;
}

async function finish() {
  const film = await end();
  if (film) last = film;
  if (filming) {
    filming = false;
    mark();
    if (film) {
      download(film, nameFor(".html"));
      line("Status", `The film ${nameFor(".html")} has ${(film.size / 1e6).toFixed(1)} MB; any browser shows it`);
    } else line("Status", "There is no film: nothing ran", "warning");
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
// The program forgets requests when the connection is lost.
on("again", () => {
  filming = false;
  mark();
  if (always) begin();
});
on("hello", mark);
