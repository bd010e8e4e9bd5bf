// @ts-check
// Collects the images and graphs that the parts of the page show, and requests all of them from the program.

import { on, send } from "tatu/net/connection";

/**
 * The objects that parts of the page show, by the name of the part.
 * @type {{ [kind in "images" | "graphs"]: Map<string, number> }}
 */
const subscriptions = { images: new Map(), graphs: new Map() };

/** Requests all objects of a kind that are shown. @param {"images" | "graphs"} kind */
function request(kind) {
  send({ type: kind, objects: [...new Set(subscriptions[kind].values())] });
}

/**
 * Sets the image or graph that a part of the page shows.
 * @param {"images" | "graphs"} kind
 * @param {string} subscriber name of the part
 * @param {number} id handle of the object; 0: none
 */
export function subscribe(kind, subscriber, id) {
  if ((subscriptions[kind].get(subscriber) ?? 0) === id) return;
  if (id) subscriptions[kind].set(subscriber, id);
  else subscriptions[kind].delete(subscriber);
  request(kind);
}

// A new connection starts without requests.
on("hello", () => {
  for (const kind of /** @type {const} */ (["images", "graphs"])) if (subscriptions[kind].size) request(kind);
});
