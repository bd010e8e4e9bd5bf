// What the page knows: the scene, what is selected, whether anything is in no file yet.

import { on, send } from "tatu/net";

/** The scene as it was sent, and its objects by handle. */
export const scene = { file: "", dt: 0.05, objects: new Map(), scripts: [] };
/** Whether this page may act. */
export const rights = { acts: true };

const watchers = { scene: [], selected: [], unsaved: [] };
let chosen = 0;

/** Calls `f` when the scene, the selection or what is unsaved changes. */
export function watch(what, f) {
  watchers[what].push(f);
}

/** The handle of the selected object; 0: none. */
export function selected() {
  return chosen;
}

/** Selects an object. */
export function select(id) {
  if (id === chosen) return;
  chosen = id;
  for (const f of watchers.selected) f(id);
  request();
}

/** Asks for the image or the streams of the selected object. */
function request() {
  const kind = scene.objects.get(chosen);
  send({ eye: kind?.schema === "image" ? chosen : 0 });
  send({ graph: kind?.kind === "graph" ? chosen : 0 });
}

/** Something was changed that is in no file. */
export function changed(is = true) {
  document.getElementById("unsaved").hidden = !is;
  sessionStorage.setItem("unsaved", is ? "1" : "");
}

on("scene", ({ scene: told }) => {
  if (told.file !== scene.file && scene.file) changed(false);
  Object.assign(scene, told);
  scene.objects = new Map(told.objects.map((o) => [o.id, o]));
  document.getElementById("name").textContent = told.file.split("/").pop() || "no scene";
  for (const f of watchers.scene) f(scene);
  if (!scene.objects.has(chosen)) select(0);
});
on("hello", ({ hello }) => {
  rights.acts = hello.acts;
  // The program forgets with a connection what was asked for over it.
  if (chosen) request();
});
document.getElementById("unsaved").hidden = !sessionStorage.getItem("unsaved");
