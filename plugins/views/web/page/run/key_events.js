// @ts-check
// Passes keys that are pressed in the 3-D view to the simulation, by the names that scripts use.

import { get } from "tatu/lib/dom";
import { send } from "tatu/net/connection";

/** @type {{ [key: string]: string }} */
const NAMES = {
  ArrowUp: "up", ArrowDown: "down", ArrowLeft: "left", ArrowRight: "right", Enter: "return", Escape: "escape",
  PageUp: "pageup", PageDown: "pagedown", Home: "home", End: "end", Delete: "delete", Backspace: "backspace", Tab: "",
};

const view = get("view");
view.addEventListener("keydown", (e) => {
  // Keys that are pressed in windows over the view, and shortcuts with modifiers, are not passed on.
  if (e.target !== view || e.ctrlKey || e.metaKey || e.altKey) return;
  const key = NAMES[e.key] ?? (e.key.length === 1 ? e.key : "");
  if (!key) return;
  send({ type: "key", key });
  e.preventDefault();
});
