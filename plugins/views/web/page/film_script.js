// The scripts of a film, to read.

import { on } from "tatu/net";

const get = (id) => document.getElementById(id);
const texts = new Map();

on("script", ({ script, text }) => texts.set(script, text));

/** Shows the text of a script. */
export function openScript(script) {
  get("script-name").textContent = script.name;
  get("editor").textContent = texts.get(script.id) ?? "";
  get("script").hidden = false;
}
get("script-close").onclick = () => { get("script").hidden = true; };
