import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import portuguese, { derivedNames } from "../lib/portuguese.js";

const page = fileURLToPath(new URL("..", import.meta.url));
const NOT_TRANSLATED = ["node_modules", "tests", "film"];

/** Returns the keys of the templates t`...` in a text: each expression becomes its number in braces. */
function templateKeys(text) {
  const keys = [];
  for (const { index } of text.matchAll(/\bt`/g)) {
    let [key, count, i] = ["", 0, index + 2];
    for (; text[i] !== "`"; i++) {
      if (text[i] === "\\") key += text[i + 1] === "u" ? JSON.parse(`"${text.slice(i, (i += 5) + 1)}"`) : text[++i];
      else if (text[i] === "$" && text[i + 1] === "{") {
        for (let depth = 0; ; i++) {
          if (text[i] === "{") depth++;
          if (text[i] === "}" && --depth === 0) break;
        }
        key += `{${count++}}`;
      } else key += text[i];
    }
    keys.push(key);
  }
  return keys;
}

const files = readdirSync(page, { recursive: true }).filter((name) => name.endsWith(".js") && !NOT_TRANSLATED.includes(name.split("/")[0]));
const source = files.filter((name) => name !== "lib/language.js").map((name) => readFileSync(join(page, name), "utf8")).join("\n");
const html = readFileSync(join(page, "index.html"), "utf8").replace(/<head>.*<\/head>/s, "").replace(/<!--.*?-->/gs, "");
const decoded = (text) => text.replaceAll("&hellip;", "\u2026").replaceAll("&times;", "\u00d7").replaceAll("&deg;", "\u00b0").replaceAll("&#9679;", "\u25cf").trim();
const inHtml = [
  ...[...html.matchAll(/ (?:title|aria-label|placeholder)="([^"]*)"/g)].map(([, text]) => decoded(text)),
  ...[...html.matchAll(/>([^<>]+)</g)].map(([, text]) => decoded(text)),
].filter((text) => /[a-z]{2}/i.test(text) && !/^\d+ ?(cm|\u00b0)/.test(text));
const keys = new Set([...templateKeys(source), ...[...source.matchAll(/\bmark\("((?:[^"\\]|\\.)*)"\)/g)].map(([, text]) => JSON.parse(`"${text}"`)), ...inHtml]);

test("every text of the page is in the table, and nothing else", () => {
  assert.ok(keys.size > 250, `${keys.size} texts`);
  assert.deepEqual([...keys].filter((key) => !(key in portuguese)), [], "texts without a translation");
  assert.deepEqual(Object.keys(portuguese).filter((key) => !keys.has(key) && !derivedNames.includes(key)), [], "translations of texts that are not there");
});

test("translations have the same values as their texts", () => {
  const values = (text) => [...text.matchAll(/\{\d+\}/g)].map(([value]) => value).sort();
  for (const [text, translation] of Object.entries(portuguese)) assert.deepEqual(values(translation), values(text), text);
});

test("texts that users read are translated", () => {
  const literal = /(?:textContent: |\.title = |[ {]title: |placeholder = |"aria-label", |writeLine\("Status", |help: |error: )(?:"[^"]*[A-Za-z]{2}|`[^`$]*[A-Za-z]{2})[^\n]*/g;
  for (const name of files.filter((f) => !["lib/language.js", "lib/portuguese.js", "lib/zip.js"].includes(f))) {
    const found = [...readFileSync(join(page, name), "utf8").matchAll(literal)].map(([text]) => text);
    assert.deepEqual(found, [], `${name}: use t\`...\``);
  }
});
