// @ts-check
// The language of the page's own texts. Texts of the program, such as errors and descriptions of properties, are English.

import portuguese from "tatu/lib/portuguese";

/** The languages, each in its own words. */
export const LANGUAGES = { en: "English", pt: "Portugu\u00eas" };
/** Translations by language, then by the English text. @type {{ [language: string]: { [text: string]: string } }} */
const TABLES = { pt: portuguese };
const KEY = "tatu language";

/** Returns the language that the user has chosen, otherwise the first known one of the browser. */
function initialLanguage() {
  const tags = [globalThis.localStorage?.getItem(KEY) ?? "", ...(globalThis.navigator?.languages ?? [])];
  return tags.map((tag) => tag.slice(0, 2)).find((tag) => tag in LANGUAGES) ?? "en";
}

export const language = initialLanguage();
const table = TABLES[language] ?? {};

/** Chooses the language, and loads the page again. @param {string} chosen */
export function setLanguage(chosen) {
  localStorage.setItem(KEY, chosen);
  location.reload();
}

/**
 * Returns the translation of an English text, or the text itself if there is none.
 * @param {string} text
 */
export function translate(text) {
  return table[text] ?? text;
}

/** Marks a text that is translated where it is shown. @param {string} text */
export function mark(text) {
  return text;
}

/**
 * Returns the translation of a template: t`Saved ${name}` has the key "Saved {0}".
 * @param {TemplateStringsArray} strings
 * @param {...unknown} values
 */
export function t(strings, ...values) {
  const key = strings.reduce((text, next, i) => `${text}{${i - 1}}${next}`);
  return translate(key).replace(/\{(\d+)\}/g, (_, i) => String(values[Number(i)]));
}

/** Attributes of elements that users read. */
const ATTRIBUTES = ["title", "aria-label", "placeholder"];

/** Translates the texts of a document that has been loaded. @param {Document} of */
export function translateDocument(of) {
  if (language === "en") return;
  of.documentElement.lang = language;
  for (const element of of.body.querySelectorAll("*")) {
    for (const name of ATTRIBUTES) {
      const text = element.getAttribute(name);
      if (text) element.setAttribute(name, translate(text));
    }
    for (const node of element.childNodes) {
      const text = node.nodeType === Node.TEXT_NODE ? node.nodeValue?.trim() : "";
      if (text && node.nodeValue) node.nodeValue = node.nodeValue.replace(text, translate(text));
    }
  }
}
