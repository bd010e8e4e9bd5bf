// @ts-check
// Buttons that choose whether a drag in the view rotates, pans or zooms the camera, as in V-REP.

import * as THREE from "three";
import { get } from "tatu/lib/dom";
import { controls } from "tatu/view/renderer";

const ACTIONS = /** @type {const} */ ({ "drag-turn": THREE.MOUSE.ROTATE, "drag-pan": THREE.MOUSE.PAN, "drag-zoom": THREE.MOUSE.DOLLY });
const KEY = "tatu drag";

/** @param {keyof typeof ACTIONS} mode */
function setMode(mode) {
  controls.mouseButtons.LEFT = ACTIONS[mode];
  for (const id of Object.keys(ACTIONS)) get(id).setAttribute("aria-pressed", String(id === mode));
  localStorage.setItem(KEY, mode);
}
const ids = /** @type {(keyof typeof ACTIONS)[]} */ (Object.keys(ACTIONS));
for (const id of ids) get(id).onclick = () => setMode(id);
setMode(ids.find((id) => id === localStorage.getItem(KEY)) ?? "drag-turn");
