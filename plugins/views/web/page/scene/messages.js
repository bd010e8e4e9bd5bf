// @ts-check
// Messages to the user: lines of text, each for a tab of the output.

import { failure, withoutCommands } from "tatu/net/calls";

/** A line: the name of its tab, its text, and its level: "", "warning" or "error". @typedef {{ tab: string, text: string, level: string }} Line */

/** @type {((line: Line) => void)[]} */
const watchers = [];

/**
 * Calls `f` with each line.
 * @param {(line: Line) => void} f
 */
export function watchLines(f) {
  watchers.push(f);
}

/**
 * Writes a line to a tab of the output.
 * @param {string} tab
 * @param {string} text
 * @param {string} [level] "", "warning" or "error"
 */
export function writeLine(tab, text, level = "") {
  for (const f of watchers) f({ tab, text, level });
}

/**
 * Writes an error to the status tab.
 * @param {unknown} thrown
 */
export function reportError(thrown) {
  const { error, help } = failure(thrown);
  const text = withoutCommands(error);
  writeLine("Status", help ? `${text} (${help})` : text, "error");
}
