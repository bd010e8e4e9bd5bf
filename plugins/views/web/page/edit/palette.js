// @ts-check
// The palette of items that can be added to the scene, either by dragging an item into the view, or by clicking it and
// then clicking a point in the view.

import { get, make } from "tatu/lib/dom";
import { icon } from "tatu/lib/icons";
import { translate } from "tatu/lib/language";
import { ask, call, on } from "tatu/net/connection";
import { reportError } from "tatu/scene/messages";
import { rights } from "tatu/scene/store";
import { FIXED, devices, models } from "tatu/edit/palette_items";
import { beginPlacement, placeInMiddle } from "tatu/edit/placement";

/** @import { Item, Section } from "tatu/edit/palette_items" */

const button = get("add");
const palette = get("palette");
const search = get("find-item", HTMLInputElement);
const list = get("items");
/** Distance that the pointer must move before a press becomes a drag, pixels. */
const CLICK_TOLERANCE = 4;
let filled = false;

// Pictures of models are requested when their items become visible.
const pictureObserver = new IntersectionObserver((entries) => {
  for (const { isIntersecting, target } of entries) {
    const picture = target.querySelector("img");
    if (!isIntersecting || !picture) continue;
    pictureObserver.unobserve(target);
    ask({ type: "model_picture", model: picture.dataset.model ?? "" }, "the picture of a model").then(([png]) => {
      if (!png) return;
      picture.src = `data:image/png;base64,${png}`;
      picture.hidden = false;
    }).catch(() => {});
  }
});

/** Creates the button of an item. @param {Item} item */
function itemButton(item) {
  const b = make("button", { className: "entry", title: translate(item.text) });
  b.dataset.item = item.name;
  if (item.model) {
    const picture = make("img", { alt: "", width: 112, height: 84, hidden: true });
    b.classList.add("pictured");
    b.append(icon("model"), picture);
    picture.dataset.model = item.model;
    pictureObserver.observe(b);
  }
  b.append(make("strong", { textContent: item.title ?? translate(item.name.replaceAll("_", " ")) }), make("small", { textContent: translate(item.text) }));
  /** @type {{ x: number, y: number } | null} */
  let press = null;
  b.onpointerdown = (e) => {
    if (e.button === 0) press = { x: e.clientX, y: e.clientY };
    // The button must not capture the pointer, so that the view receives its events.
    b.releasePointerCapture(e.pointerId);
  };
  addEventListener("pointermove", (e) => {
    if (!press || Math.hypot(e.clientX - press.x, e.clientY - press.y) <= CLICK_TOLERANCE) return;
    press = null;
    beginPlacement(item, true);
  });
  addEventListener("pointerup", () => { press = null; });
  b.onclick = (e) => {
    // A click by the keyboard has no position, so the item is placed at the middle of the view.
    if (e.detail === 0) placeInMiddle(item);
    else beginPlacement(item, false);
  };
  return b;
}

/** Creates a section. @param {Section} section */
function sectionElement({ name, items }) {
  const element = make("details", { open: name === FIXED[0]?.name });
  const group = make("div", { className: items.some((item) => item.model) ? "pictures" : "" });
  group.append(...items.map(itemButton));
  element.append(make("summary", { textContent: translate(name) }), group);
  return element;
}

/** Requests the kinds of devices and the models, and fills the palette. */
async function fill() {
  filled = true;
  try {
    const [[kinds], [modelList]] = await Promise.all([call("tatu.kinds"), call("tatu.models")]);
    const [shapes, joints, others] = FIXED;
    const sections = [shapes, ...models(modelList), joints, ...devices(kinds), others].filter((s) => s !== undefined);
    list.replaceChildren(...sections.map(sectionElement));
  } catch (thrown) {
    filled = false;
    reportError(thrown);
  }
}

/** Shows or hides the palette. @param {boolean} isShown */
function show(isShown) {
  palette.hidden = !isShown;
  button.setAttribute("aria-pressed", String(isShown));
  if (isShown && !filled) fill();
  if (isShown) search.focus();
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
  for (const element of list.querySelectorAll("details")) {
    let isAnyShown = false;
    for (const b of element.querySelectorAll("button")) {
      const name = `${b.dataset.item} ${b.textContent}`.toLowerCase();
      b.hidden = !words.every((word) => name.includes(word));
      isAnyShown ||= !b.hidden;
    }
    element.hidden = !isAnyShown;
    element.open = search.value ? isAnyShown : element === list.firstElementChild;
  }
};
on("hello", ({ acts }) => { button.hidden = !acts; });
on("again", () => { filled = false; if (!palette.hidden) fill(); });
if (!rights.canControl) button.hidden = true;
