// @ts-check
// Collects the images, depths and graphs that the parts of the page show, and requests all of them from the program.

import { on, send } from "tatu/net/connection";

/** @typedef {"images" | "depths" | "graphs"} Kind */
/**
 * The objects that parts of the page show, by the name of the part.
 * @type {{ [kind in Kind]: Map<string, number> }}
 */
const subscriptions = { images: new Map(), depths: new Map(), graphs: new Map() };

/** Requests all objects of a kind that are shown. @param {Kind} kind */
function request(kind) {
  const shown = (/** @type {Kind} */ of) => [...new Set(subscriptions[of].values())];
  if (kind === "graphs") send({ type: "graphs", objects: shown("graphs") });
  else send({ type: "images", objects: shown("images"), depths: shown("depths") });
}

/**
 * Sets the image, image of depths, or graph that a part of the page shows.
 * @param {Kind} kind
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
  if (subscriptions.images.size || subscriptions.depths.size) request("images");
  if (subscriptions.graphs.size) request("graphs");
});
