// @ts-check
// The palette of items that can be added to the scene, either by dragging an item into the view, or by clicking it and
// then clicking a point in the view.

import { get, make } from "tatu/lib/dom";
import { call, on } from "tatu/net/connection";
import { tell } from "tatu/scene/messages";
import { rights } from "tatu/scene/store";
import { FIXED, devices, models } from "tatu/edit/palette_items";
import { begin, putInMiddle } from "tatu/edit/placement";

/** @import { Item, Section } from "tatu/edit/palette_items" */

const button = get("add");
const palette = get("palette");
const search = get("find-item", HTMLInputElement);
const list = get("items");
/** Distance that the pointer must move before a press becomes a drag, pixels. */
const STILL = 4;
let filled = false;

/** Creates the button of an item. @param {Item} item */
function entry(item) {
  const b = make("button", { className: "entry", title: item.text });
  b.dataset.item = item.name;
  b.append(make("strong", { textContent: item.name.replaceAll("_", " ") }), make("small", { textContent: item.text }));
  /** @type {{ x: number, y: number } | null} */
  let down = null;
  b.onpointerdown = (e) => {
    if (e.button === 0) down = { x: e.clientX, y: e.clientY };
    // The button must not capture the pointer, so that the view receives its events.
    b.releasePointerCapture(e.pointerId);
  };
  addEventListener("pointermove", (e) => {
    if (!down || Math.hypot(e.clientX - down.x, e.clientY - down.y) <= STILL) return;
    down = null;
    begin(item, true);
  });
  addEventListener("pointerup", () => { down = null; });
  b.onclick = (e) => {
    // A click by the keyboard has no position, so the item is placed at the middle of the view.
    if (e.detail === 0) putInMiddle(item);
    else begin(item, false);
  };
  return b;
}

/** Creates a section. @param {Section} section */
function part({ name, items }) {
  const own = make("details", { open: name === "Shapes" });
  own.append(make("summary", { textContent: name }), ...items.map(entry));
  return own;
}

/** Requests the kinds of devices and the models, and fills the palette. */
async function fill() {
  filled = true;
  try {
    const [[kinds], [known]] = await Promise.all([call("tatu.kinds"), call("tatu.models")]);
    const [shapes, joints, others] = FIXED;
    const sections = [shapes, joints, ...devices(kinds), others, models(known)].filter((s) => s !== undefined);
    list.replaceChildren(...sections.map(part));
  } catch (thrown) {
    filled = false;
    tell(thrown);
  }
}

/** Shows or hides the palette. @param {boolean} is */
function show(is) {
  palette.hidden = !is;
  button.setAttribute("aria-pressed", String(is));
  if (is && !filled) fill();
  if (is) search.focus();
}

button.onclick = () => show(palette.hidden);
palette.addEventListener("keydown", (e) => {
  if (e.key !== "Escape") return;
  show(false);
  button.focus();
  e.stopPropagation();
});
search.oninput = () => {
  const words = search.value.toLowerCase().split(/\s+/);
  for (const own of list.querySelectorAll("details")) {
    let some = false;
    for (const b of own.querySelectorAll("button")) {
      const name = `${b.dataset.item} ${b.textContent}`.toLowerCase();
      b.hidden = !words.every((word) => name.includes(word));
      some ||= !b.hidden;
    }
    own.hidden = !some;
    own.open = search.value ? some : own.firstElementChild?.textContent === "Shapes";
  }
};
on("hello", ({ acts }) => { button.hidden = !acts; });
on("again", () => { filled = false; if (!palette.hidden) fill(); });
if (!rights.acts) button.hidden = true;
