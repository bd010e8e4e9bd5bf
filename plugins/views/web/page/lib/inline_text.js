// @ts-check
// Shows emphasis in texts of scenes: `keys and names`, *stressed* and **strongly stressed** words.

import { make } from "tatu/lib/dom";

/** A part of a text, and the name of the element that shows it; "": plain text. @typedef {{ tag: "" | "code" | "strong" | "em", text: string }} Part */

/** Marked words. Asterisks within words or beside spaces, as in products, mark nothing. */
const MARKED = /`([^`\n]+)`|(?<![\w*])\*\*([^\s*](?:[^*]*[^\s*])?)\*\*(?![\w*])|(?<![\w*])\*([^\s*](?:[^*]*[^\s*])?)\*(?![\w*])/g;

/**
 * Returns the parts of a text.
 * @param {string} text
 */
export function partsOf(text) {
  /** @type {Part[]} */
  const parts = [];
  let end = 0;
  for (const match of text.matchAll(MARKED)) {
    const [all, code, strong, em] = match;
    if (match.index > end) parts.push({ tag: "", text: text.slice(end, match.index) });
    parts.push(code ? { tag: "code", text: code } : strong ? { tag: "strong", text: strong } : { tag: "em", text: em ?? "" });
    end = match.index + all.length;
  }
  if (end < text.length) parts.push({ tag: "", text: text.slice(end) });
  return parts;
}

/** Returns the nodes that show a text. @param {string} text @returns {(Node | string)[]} */
export function inlineNodes(text) {
  return partsOf(text).map(({ tag, text: words }) => (tag ? make(tag, { textContent: words }) : words));
}
