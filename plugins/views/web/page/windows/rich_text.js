// @ts-check
// Shows formatted text of scripts. Supported tags are converted to DOM elements; the text is never inserted as HTML.

const TAGS = new Set(["B", "I", "U", "BIG", "SMALL", "BR", "P", "H1", "H2", "H3", "H4", "TABLE", "TBODY", "TR", "TD", "TH", "UL", "OL", "LI", "CENTER", "FONT", "SPAN", "DIV", "STRONG", "EM", "HR", "PRE", "TT", "CODE", "A"]);

/** CSS properties that the style of a script may set. */
const STYLES = ["color", "background-color", "font-size", "font-weight", "font-style", "text-align"];

/** @typedef {(href: string) => void} OnLink */

/**
 * Applies a style sheet of a script to an element, and removes the style that was applied before.
 * @param {HTMLElement} element
 * @param {unknown} text
 */
export function applyStyle(element, text) {
  for (const key of STYLES) element.style.removeProperty(key);
  for (const declaration of String(text ?? "").replace(/^[^{]*\{|\}.*$/g, "").split(";")) {
    const [key, value] = declaration.split(":").map((x) => x.trim());
    if (key && value && STYLES.includes(key) && !value.includes("url")) element.style.setProperty(key, value);
  }
}

/**
 * Appends copies of the children of a node to an element. Unsupported tags are replaced by their content, except
 * scripts and style sheets, which are dropped.
 * @param {Element} node
 * @param {HTMLElement} to
 * @param {OnLink} [onLink]
 */
function copy(node, to, onLink) {
  for (const child of node.childNodes) {
    if (child.nodeType === Node.TEXT_NODE) to.append(child.textContent ?? "");
    if (!(child instanceof Element)) continue;
    if (!TAGS.has(child.tagName)) { if (child.tagName !== "SCRIPT" && child.tagName !== "STYLE") copy(child, to, onLink); continue; }
    const link = child.tagName === "A";
    const created = document.createElement(link ? "button" : child.tagName === "FONT" ? "span" : child.tagName);
    if (link) {
      created.className = "link";
      created.onclick = () => onLink?.(child.getAttribute("href") ?? "");
    }
    if (child.getAttribute("color")) applyStyle(created, `color:${child.getAttribute("color")}`);
    if (child.getAttribute("style")) applyStyle(created, child.getAttribute("style"));
    copy(child, created, onLink);
    to.append(created);
  }
}

/**
 * Replaces the content of an element by text that may contain tags.
 * @param {HTMLElement} element
 * @param {unknown} text
 * @param {OnLink} [onLink] called when a link is clicked
 */
export function setRichText(element, text, onLink) {
  element.replaceChildren();
  const source = String(text ?? "");
  if (!/[<&]/.test(source)) element.append(source);
  else copy(new DOMParser().parseFromString(source, "text/html").body, element, onLink);
}
