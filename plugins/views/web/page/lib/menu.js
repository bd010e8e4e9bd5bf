// @ts-check
// Context menus and menus of buttons. Names of entries are translated here.

import { make } from "tatu/lib/dom";
import { translate } from "tatu/lib/language";

/**
 * An entry of a menu: `keys` is the keyboard shortcut, which is shown at the right; `isDisabled` is whether the entry
 * is disabled.
 * @typedef {{ name: string, keys: string, action: () => void, isDisabled: boolean }} Entry
 */

/** @type {HTMLElement | null} */
let open = null;
/** The element that had the focus before the menu was opened. @type {Element | null} */
let previousFocus = null;

function close() {
  open?.remove();
  open = null;
  if (previousFocus instanceof HTMLElement) previousFocus.focus({ preventScroll: true });
}

/**
 * Opens a menu at a position in the window, moved so that it is completely visible.
 * @param {number} x pixels
 * @param {number} y pixels
 * @param {Entry[]} entries
 */
export function openMenu(x, y, entries) {
  open?.remove();
  previousFocus = document.activeElement;
  const menu = make("div", { className: "menu" });
  menu.setAttribute("role", "menu");
  for (const { name, keys, action, isDisabled } of entries) {
    const b = make("button", { disabled: isDisabled });
    b.setAttribute("role", "menuitem");
    b.append(make("span", { textContent: translate(name) }), make("small", { textContent: keys }));
    b.onclick = () => {
      close();
      action();
    };
    menu.append(b);
  }
  document.body.append(menu);
  const { width, height } = menu.getBoundingClientRect();
  menu.style.left = `${Math.max(4, Math.min(x, innerWidth - width - 4))}px`;
  menu.style.top = `${Math.max(4, Math.min(y, innerHeight - height - 4))}px`;
  open = menu;
  menu.querySelector("button")?.focus();
  menu.onkeydown = (e) => {
    const all = [...menu.querySelectorAll("button")].filter((b) => !b.disabled);
    const at = all.findIndex((b) => b === document.activeElement);
    if (e.key === "Escape") close();
    else if (e.key === "ArrowDown") all[(at + 1) % all.length]?.focus();
    else if (e.key === "ArrowUp") all[(at - 1 + all.length) % all.length]?.focus();
    else if (e.key !== "Enter" && e.key !== " " && e.key !== "Tab") return;
    if (e.key !== "Enter" && e.key !== " ") e.preventDefault();
    e.stopPropagation();
  };
}
addEventListener("pointerdown", (e) => { if (open && !(e.target instanceof Node && open.contains(e.target))) close(); }, true);
