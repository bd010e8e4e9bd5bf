// @ts-check
// Replaces the module `documents/script_editor` in a film: shows scripts read-only.

import { get } from "tatu/lib/dom";
import { on } from "tatu/net/connection";

/** @import { Script } from "tatu/protocol" */

/** The sources of scripts, by handle. @type {Map<number, string>} */
const texts = new Map();

on("script", ({ script, text }) => texts.set(script, text));

/**
 * Shows the source of a script.
 * @param {Script} script
 */
export function openScript(script) {
  get("script-name").textContent = script.name;
  get("editor").textContent = texts.get(script.id) ?? "";
  get("script").hidden = false;
}
get("script-close").onclick = () => { get("script").hidden = true; };
