// @ts-check
// The bars between the panels and the view, which are moved by a drag or by the arrow keys. Their positions are stored
// in the browser.

import { get, make } from "tatu/lib/dom";
import { t } from "tatu/lib/language";

const main = get("middle").parentElement ?? document.body;
/** Distance by which a key moves a bar, pixels. */
const STEP = 16;
/** Minimum width of a panel, and of the view between the panels, pixels. */
const [MIN_WIDTH, MIN_VIEW_WIDTH] = [110, 320];

/**
 * Creates the bar at a side of the view, which sets the width of the panel there.
 * @param {"left" | "right"} side
 * @param {string} name
 */
function splitter(side, name) {
  const panel = main.querySelector(side === "left" ? "nav" : "aside");
  if (!(panel instanceof HTMLElement)) return;
  const bar = make("div", { className: "splitter", tabIndex: 0, title: t`${name}: drag, or arrow keys; a double click restores the default width` });
  bar.setAttribute("role", "separator");
  bar.setAttribute("aria-orientation", "vertical");
  bar.setAttribute("aria-label", name);
  const key = `tatu ${side}`;

  function show() {
    const width = panel?.offsetWidth ?? 0;
    bar.style[side] = `${width - 5}px`;
    bar.setAttribute("aria-valuenow", String(width));
    bar.setAttribute("aria-valuemin", String(MIN_WIDTH));
    bar.setAttribute("aria-valuemax", String(maxWidth()));
  }
  function maxWidth() {
    const other = main.querySelector(side === "left" ? "aside" : "nav");
    return Math.max(MIN_WIDTH, main.clientWidth - MIN_VIEW_WIDTH - (other instanceof HTMLElement ? other.offsetWidth : 0));
  }
  /** Sets the width of the panel. @param {number} width pixels; 0: the default width */
  function set(width) {
    if (width > 0) main.style.setProperty(`--${side}`, `${Math.round(Math.max(MIN_WIDTH, Math.min(width, maxWidth())))}px`);
    else main.style.removeProperty(`--${side}`);
    if (width > 0) localStorage.setItem(key, String(panel?.offsetWidth));
    else localStorage.removeItem(key);
    show();
  }
  bar.onpointerdown = (e) => {
    bar.setPointerCapture(e.pointerId);
    bar.classList.add("going");
    const box = main.getBoundingClientRect();
    bar.onpointermove = (m) => set(side === "left" ? m.clientX - box.left : box.right - m.clientX);
    bar.onpointerup = bar.onpointercancel = () => {
      bar.onpointermove = null;
      bar.classList.remove("going");
    };
  };
  bar.ondblclick = () => set(0);
  bar.onkeydown = (e) => {
    const direction = e.key === "ArrowLeft" ? -1 : e.key === "ArrowRight" ? 1 : 0;
    if (!direction) return;
    e.preventDefault();
    set((panel?.offsetWidth ?? 0) + STEP * direction * (side === "left" ? 1 : -1));
  };
  main.append(bar);
  const stored = Number(localStorage.getItem(key));
  if (stored > 0) set(stored);
  new ResizeObserver(show).observe(panel);
  show();
}
splitter("left", t`Width of the tree`);
splitter("right", t`Width of the properties`);
