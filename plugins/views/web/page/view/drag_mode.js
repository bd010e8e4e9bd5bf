// @ts-check
// Buttons that choose whether a drag in the view rotates, pans or zooms the camera, as in V-REP.

import * as THREE from "three";
import { get } from "tatu/lib/dom";
import { controls } from "tatu/view/renderer";

const WAYS = /** @type {const} */ ({ "drag-turn": THREE.MOUSE.ROTATE, "drag-pan": THREE.MOUSE.PAN, "drag-zoom": THREE.MOUSE.DOLLY });
const KEY = "tatu drag";

/** @param {keyof typeof WAYS} way */
function choose(way) {
  controls.mouseButtons.LEFT = WAYS[way];
  for (const id of Object.keys(WAYS)) get(id).setAttribute("aria-pressed", String(id === way));
  localStorage.setItem(KEY, way);
}
const ids = /** @type {(keyof typeof WAYS)[]} */ (Object.keys(WAYS));
for (const id of ids) get(id).onclick = () => choose(id);
choose(ids.find((id) => id === localStorage.getItem(KEY)) ?? "drag-turn");
