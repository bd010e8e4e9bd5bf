// @ts-check
// What is shown of sensors' images and of graphs, by whom; the program is told of all together.

import { on, send } from "tatu/net";

/** @type {{ [kind in "images" | "graphs"]: Map<string, number> }} */
const shown = { images: new Map(), graphs: new Map() };

/** @param {"images" | "graphs"} kind */
function ask(kind) {
  send({ type: kind, objects: [...new Set(shown[kind].values())] });
}

/**
 * Says what one part of the page shows.
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

// The program forgets with a connection what was asked for over it.
on("hello", () => {
  for (const kind of /** @type {const} */ (["images", "graphs"])) if (shown[kind].size) ask(kind);
});
