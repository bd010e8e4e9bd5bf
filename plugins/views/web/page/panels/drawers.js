// @ts-check
// On narrow screens, the panels beside the view are drawers over it, of which at most one is open, and the tools for moving
// are in the view.

import { get } from "tatu/lib/dom";

/** Screens that are too narrow for panels beside the view; style.css has the same width. */
const narrow = matchMedia("(max-width: 999px)");
const DRAWERS = /** @type {const} */ ({ objects: "show-objects", details: "show-details" });
const [palette, script] = [get("palette"), get("script")];
const tools = get("tools");
/** The place of the tools on wide screens. */
const toolsPlace = document.createComment("tools");
tools.before(toolsPlace);

/** Opens a drawer, and closes the others; "" closes all. @param {keyof typeof DRAWERS | ""} name */
function openDrawer(name) {
  for (const [drawer, button] of Object.entries(DRAWERS)) {
    get(drawer).classList.toggle("open", drawer === name);
    get(button).setAttribute("aria-expanded", String(drawer === name));
  }
  // The palette is closed by its button, which shows whether it is open.
  if (name && !palette.hidden && narrow.matches) get("add").click();
}
for (const [drawer, button] of Object.entries(DRAWERS)) {
  const name = /** @type {keyof typeof DRAWERS} */ (drawer);
  get(button).onclick = () => openDrawer(get(drawer).classList.contains("open") ? "" : name);
  get(drawer).addEventListener("keydown", (e) => {
    if (e.key !== "Escape" || !narrow.matches || e.defaultPrevented) return;
    openDrawer("");
    get(button).focus();
  });
}
get("view").addEventListener("pointerdown", () => openDrawer(""));
// The palette and the editor take the place of a drawer.
new MutationObserver(() => { if (!palette.hidden || !script.hidden) openDrawer(""); }).observe(palette, { attributeFilter: ["hidden"] });
new MutationObserver(() => { if (!script.hidden) openDrawer(""); }).observe(script, { attributeFilter: ["hidden"] });

function placeTools() {
  if (narrow.matches) get("view").append(tools);
  else toolsPlace.after(tools);
  tools.classList.toggle("over", narrow.matches);
  openDrawer("");
}
narrow.addEventListener("change", placeTools);
placeTools();

// The rest of the camera's controls, which a narrow view shows only on request.
const [more, rest] = [get("more-camera"), get("camera-rest")];
/** @param {boolean} isOpen */
function showRest(isOpen) {
  rest.classList.toggle("open", isOpen);
  more.setAttribute("aria-expanded", String(isOpen));
}
more.onclick = () => showRest(!rest.classList.contains("open"));
rest.addEventListener("keydown", (e) => {
  if (e.key !== "Escape" || !rest.classList.contains("open")) return;
  showRest(false);
  more.focus();
});
addEventListener("pointerdown", (e) => {
  if (e.target instanceof Node && !rest.contains(e.target) && !more.contains(e.target)) showRest(false);
}, true);
