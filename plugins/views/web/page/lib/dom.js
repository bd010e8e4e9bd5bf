// @ts-check
// Helper functions for DOM elements.

/**
 * Returns the element with the given id. Throws an error if it does not exist or is not of the given class.
 * @template {Element} [T=HTMLElement]
 * @param {string} id
 * @param {new () => T} [type]
 * @returns {T}
 */
export function get(id, type) {
  const found = document.getElementById(id);
  const expected = type ?? HTMLElement;
  if (!(found instanceof expected)) throw new Error(`the page has no ${expected.name} with the id "${id}"`);
  return /** @type {T} */ (/** @type {Element} */ (found));
}

/**
 * Creates an element, and sets properties of it.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Partial<HTMLElementTagNameMap[K]>} [properties]
 * @returns {HTMLElementTagNameMap[K]}
 */
export function make(tag, properties = {}) {
  return Object.assign(document.createElement(tag), properties);
}
