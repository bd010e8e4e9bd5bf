// @ts-check
// Repeats requests only as long as something happens: while a scene is stopped and nobody edits it, the page is silent.

import { on } from "tatu/net/connection";

/** Number of messages that reported a change. */
let changes = 0;
for (const kind of /** @type {const} */ (["scene", "objects", "frame", "readings", "values", "state", "event"])) {
  on(kind, () => { changes++; });
}

/**
 * Calls `f` at most once per interval, if the page is visible and something has changed since the last call.
 * @param {number} interval ms
 * @param {() => void} f
 */
export function whileActive(interval, f) {
  let seen = -1;
  setInterval(() => {
    if (document.hidden || changes === seen) return;
    seen = changes;
    f();
  }, interval);
}
