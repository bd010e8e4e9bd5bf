// @ts-check
// Tracks which images and graphs the parts of the page show, and requests the union of them from the program.

import { on, send } from "tatu/net";

/** @type {{ [kind in "images" | "graphs"]: Map<string, number> }} */
const shown = { images: new Map(), graphs: new Map() };

/** @param {"images" | "graphs"} kind */
function ask(kind) {
  send({ type: kind, objects: [...new Set(shown[kind].values())] });
}

/**
 * Sets the object that a part of the page shows.
 * @param {"images" | "graphs"} kind
 * @param {string} who
 * @param {number} id 0: nothing
 */
export function want(kind, who, id) {
  if ((shown[kind].get(who) ?? 0) === id) return;
  if (id) shown[kind].set(who, id);
  else shown[kind].delete(who);
  ask(kind);
}

// The program forgets requests when the connection is lost.
on("hello", () => {
  for (const kind of /** @type {const} */ (["images", "graphs"])) if (shown[kind].size) ask(kind);
});
