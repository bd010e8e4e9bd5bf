// @ts-check
// Windows over the view, which can be moved by their title bar, resized at a corner, and closed. The window that was
// used last is in front.

import { get, make } from "tatu/lib/dom";
import { t } from "tatu/lib/language";

/**
 * A window: its element, its title bar and title, the element for its content, and a function that closes it.
 * @typedef {{ box: HTMLElement, bar: HTMLElement, title: HTMLElement, body: HTMLElement, close: () => void }} FloatingWindow
 */

const host = get("view");
/** Distance by which a key moves a window, pixels. */
const STEP = 16;
/** Distance between new windows and the edges of the view, pixels. */
const MARGIN = 10;
let topLayer = 2;

/**
 * Moves a window to a position in the view, clamped so that its title bar remains within the view.
 * @param {HTMLElement} box
 * @param {number} x
 * @param {number} y
 */
function moveTo(box, x, y) {
  box.style.left = `${Math.round(Math.max(0, Math.min(x, host.clientWidth - 60)))}px`;
  box.style.top = `${Math.round(Math.max(0, Math.min(y, host.clientHeight - 30)))}px`;
}

/**
 * Moves a window to a position in the view, clamped so that all of it is in the view if it fits.
 * @param {HTMLElement} box
 * @param {number} x
 * @param {number} y
 */
function moveInside(box, x, y) {
  moveTo(box, Math.max(0, Math.min(x, host.clientWidth - box.offsetWidth)), Math.max(0, Math.min(y, host.clientHeight - box.offsetHeight)));
}

/**
 * Returns a position at which a new window does not cover another one, as far to the right as possible. If there is
 * none, returns one with a small offset that depends on the number of windows.
 * @param {HTMLElement} box
 */
function freePosition(box) {
  const [w, h] = [box.offsetWidth, box.offsetHeight];
  const otherWindows = [...host.querySelectorAll(".window")].filter((o) => o instanceof HTMLElement && o !== box && !o.hidden);
  const covers = (/** @type {number} */ x, /** @type {number} */ y) => otherWindows.some((o) => (
    o instanceof HTMLElement && x < o.offsetLeft + o.offsetWidth && o.offsetLeft < x + w && y < o.offsetTop + o.offsetHeight && o.offsetTop < y + h
  ));
  const right = host.clientWidth - w - MARGIN;
  const bar = get("camera");
  const top = bar.offsetTop + bar.offsetHeight + MARGIN;
  for (let x = right; x >= MARGIN; x -= STEP) {
    for (let y = top; y <= host.clientHeight - h - MARGIN; y += STEP) if (!covers(x, y)) return { x, y };
  }
  return { x: right - 24 * (otherWindows.length % 8), y: top + 34 * (otherWindows.length % 8) };
}

/**
 * Makes a window movable by its title bar. The view behind the window does not receive its keyboard and pointer events.
 * @param {HTMLElement} box
 * @param {HTMLElement} bar the title bar
 * @param {() => void} [onMoved] called at the end of a drag
 */
export function movable(box, bar, onMoved = () => {}) {
  for (const kind of ["keydown", "pointerdown", "pointerup", "wheel", "dblclick"]) box.addEventListener(kind, (e) => e.stopPropagation());
  box.addEventListener("pointerdown", () => { box.style.zIndex = String(++topLayer); }, true);
  bar.onpointerdown = (e) => {
    if (e.target !== bar) return;
    const [x, y] = [e.clientX - box.offsetLeft, e.clientY - box.offsetTop];
    bar.setPointerCapture(e.pointerId);
    bar.onpointermove = (m) => moveTo(box, m.clientX - x, m.clientY - y);
    bar.onpointerup = bar.onpointercancel = () => {
      bar.onpointermove = null;
      onMoved();
    };
  };
}

/** @type {{ [key: string]: [number, number] }} */
const DIRECTIONS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** @param {string} key of the window */
const storageKey = (key) => `tatu window ${key}`;

/** Returns whether the position and size of a window are stored. @param {string} key */
export function hasPlacement(key) {
  return localStorage.getItem(storageKey(key)) !== null;
}

/**
 * Stores the position and size of a window.
 * @param {string} key
 * @param {number[]} placement left, top, width and height, pixels
 */
export function storePlacement(key, placement) {
  localStorage.setItem(storageKey(key), placement.join(" "));
}

/**
 * Opens a window. Its position and size are stored in the browser under `key`.
 * @param {{ key: string, title: string, width: number, height?: number, closed: () => void }} what
 * @returns {FloatingWindow}
 */
export function openFloatingWindow({ key, title: text, width, height, closed }) {
  const box = make("section", { className: "window pane" });
  box.setAttribute("aria-label", text);
  const bar = make("div", { className: "title", tabIndex: 0, title: t`Drag, or arrow keys: move; with Shift: size; Escape: close` });
  bar.setAttribute("role", "group");
  bar.setAttribute("aria-label", t`Window ${text}`);
  const title = make("span", { textContent: text });
  const closeButton = make("button", { type: "button", textContent: "\u00D7", title: t`Close` });
  closeButton.setAttribute("aria-label", t`Close ${text}`);
  bar.append(title, closeButton);
  const body = make("div", { className: "body" });
  box.append(bar, body);

  const store = () => {
    if (box.offsetWidth) storePlacement(key, [box.offsetLeft, box.offsetTop, box.offsetWidth, box.offsetHeight]);
  };
  const [x, y, w, h] = (localStorage.getItem(storageKey(key)) ?? "").split(" ").map(Number);
  box.style.width = `${w || width}px`;
  if (h ?? height) box.style.height = `${h ?? height}px`;
  movable(box, bar, store);
  const sizeObserver = new ResizeObserver(() => { if (box.isConnected) store(); });
  bar.addEventListener("keydown", (e) => {
    const direction = DIRECTIONS[e.key];
    if (e.key === "Escape") close();
    if (!direction || e.target !== bar) return;
    e.preventDefault();
    const [dx, dy] = [STEP * direction[0], STEP * direction[1]];
    if (e.shiftKey) Object.assign(box.style, { width: `${box.offsetWidth + dx}px`, height: `${box.offsetHeight + dy}px` });
    else moveTo(box, box.offsetLeft + dx, box.offsetTop + dy);
    store();
  });
  const close = () => {
    sizeObserver.disconnect();
    box.remove();
    closed();
  };
  closeButton.onclick = close;
  box.style.zIndex = String(++topLayer);
  host.append(box);
  const placement = w ? null : freePosition(box);
  // The view may have been larger when the placement was stored.
  moveInside(box, placement?.x ?? x ?? 0, placement?.y ?? y ?? 0);
  sizeObserver.observe(box);
  return { box, bar, title, body, close };
}

// When the size of the view changes, windows are moved into the view if they fit.
new ResizeObserver(() => {
  if (!host.clientWidth) return;
  for (const box of host.querySelectorAll(".pane")) {
    if (box instanceof HTMLElement) moveInside(box, box.offsetLeft, box.offsetTop);
  }
}).observe(host);
