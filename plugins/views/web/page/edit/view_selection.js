// @ts-check
// Selects objects in the view by clicks and by a box. A click selects the model, a second click the part.

import * as THREE from "three";
import { get, make } from "tatu/lib/dom";
import { editState } from "tatu/scene/edits";
import { modelOf } from "tatu/scene/hierarchy";
import { rights, scene, select, selectAll, selected, selection } from "tatu/scene/store";
import { groups } from "tatu/view/objects";
import { hitAt } from "tatu/view/picking";
import { camera, controls, host, renderer } from "tatu/view/renderer";
import { isPlacing } from "tatu/edit/placement";

const canvas = renderer.domElement;
const tool = get("select");
/** Distance that the pointer must move before a click becomes a drag, pixels. */
const CLICK_TOLERANCE = 4;

/** Selects the model that contains the selected object, or nothing if there is none. */
export function selectModelAbove() {
  let o = scene.objects.get(selected());
  for (o = o && scene.objects.get(o.parent); o; o = scene.objects.get(o.parent)) {
    if (!o.model) continue;
    select(o.id);
    return;
  }
  select(0);
}

/** @type {{ x: number, y: number, free: boolean } | null} */
let press = null;
canvas.addEventListener("pointerdown", (e) => {
  host.focus({ preventScroll: true });
  press = e.button === 0 && !isPlacing() ? { x: e.clientX, y: e.clientY, free: true } : null;
});
canvas.addEventListener("pointerup", (e) => {
  const start = press;
  press = null;
  if (!start || Math.hypot(e.clientX - start.x, e.clientY - start.y) > CLICK_TOLERANCE) return;
  const part = hitAt(e)?.id ?? 0;
  const model = modelOf(part);
  if (e.ctrlKey || e.metaKey || e.shiftKey) {
    if (part) select(model, true);
    return;
  }
  // A second click on a model selects the part.
  const isSecondClick = selected() === model || (selected() === part && part !== 0);
  select(isSecondClick ? part : model);
});

// A double click looks at a point, and must not select a part of the model by its second click.
canvas.addEventListener("dblclick", (e) => {
  const part = hitAt(e)?.id ?? 0;
  if (part && selected() === part) select(modelOf(part));
});

// A drag selects by a box if the tool is active, or with Shift. During a run, a drag with Shift pushes bodies, so it
// must then start on the ground.
tool.onclick = () => tool.setAttribute("aria-pressed", String(tool.getAttribute("aria-pressed") !== "true"));
const frame = make("div", { id: "box", hidden: true });
host.append(frame);
/** @type {{ x: number, y: number, add: boolean } | null} */
let box = null;

/** Returns whether the pointer is over a floor, or over no object. @param {PointerEvent} e */
function isGround(e) {
  const id = hitAt(e)?.id;
  return id === undefined || (scene.objects.get(id)?.parts ?? []).every((p) => p.form === "plane");
}

canvas.addEventListener("pointerdown", (e) => {
  if (e.button !== 0 || isPlacing()) return;
  const byTool = tool.getAttribute("aria-pressed") === "true";
  const canPush = rights.canControl && editState.state === "running";
  if (!byTool && !(e.shiftKey && (!canPush || isGround(e)))) return;
  box = { x: e.clientX, y: e.clientY, add: e.ctrlKey || e.metaKey };
  controls.enabled = false;
}, true);
addEventListener("pointermove", (e) => {
  if (!box) return;
  const at = host.getBoundingClientRect();
  const [x, y] = [Math.min(e.clientX, box.x), Math.min(e.clientY, box.y)];
  frame.hidden = false;
  Object.assign(frame.style, {
    left: `${x - at.left}px`, top: `${y - at.top}px`,
    width: `${Math.abs(e.clientX - box.x)}px`, height: `${Math.abs(e.clientY - box.y)}px`,
  });
});
addEventListener("pointerup", (e) => {
  const start = box;
  if (!start) return;
  box = null;
  frame.hidden = true;
  controls.enabled = true;
  if (Math.hypot(e.clientX - start.x, e.clientY - start.y) <= CLICK_TOLERANCE) return;
  const found = objectsInBox(start, { x: e.clientX, y: e.clientY });
  selectAll(start.add ? [...selection(), ...found] : found);
});

/**
 * Returns the objects in a box on the screen, or the models that contain them. An object is in the box if the origin of
 * its first part is, or its own origin if it has no parts. Floors and invisible objects are omitted.
 * @param {{ x: number, y: number }} a
 * @param {{ x: number, y: number }} b
 */
function objectsInBox(a, b) {
  const at = canvas.getBoundingClientRect();
  camera.updateMatrixWorld();
  const center = new THREE.Vector3();
  /** @type {Set<number>} */
  const found = new Set();
  for (const [id, group] of groups) {
    const { bodies } = group.userData;
    if (bodies.length && bodies.every((mesh) => !mesh.visible || mesh.geometry.type === "PlaneGeometry")) continue;
    if (!bodies.length && !scene.objects.get(id)?.visible) continue;
    (bodies[0] ?? group).getWorldPosition(center).project(camera);
    const x = at.left + ((center.x + 1) / 2) * at.width;
    const y = at.top + ((1 - center.y) / 2) * at.height;
    const inside = x >= Math.min(a.x, b.x) && x <= Math.max(a.x, b.x) && y >= Math.min(a.y, b.y) && y <= Math.max(a.y, b.y);
    if (inside && Math.abs(center.z) <= 1) found.add(modelOf(id));
  }
  return [...found];
}
