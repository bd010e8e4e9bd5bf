// @ts-check
// Adds objects at a point of the view that the user chooses: a preview follows the pointer, and the object is placed on
// the surface under the pointer.

import * as THREE from "three";
import { t } from "tatu/lib/language";
import { call } from "tatu/net/connection";
import { edit, newMergeKey } from "tatu/scene/edits";
import { subtree } from "tatu/scene/hierarchy";
import { reportError, writeLine } from "tatu/scene/messages";
import { scene, selectWhenPresent, whenPresent } from "tatu/scene/store";
import { root } from "tatu/view/objects";
import { surfaceAt, viewCenter } from "tatu/view/picking";
import { controls, host, redraw, stage } from "tatu/view/renderer";
import { boxOf } from "tatu/edit/alignment";
import { lengthStep, snapLength } from "tatu/edit/snap_settings";

/** @import { Item } from "tatu/edit/palette_items" */
/** @import { Pointer } from "tatu/view/picking" */

/** The item that is being placed. @type {{ item: Item, dragged: boolean } | null} */
let pending = null;
const previewMaterial = new THREE.MeshLambertMaterial({ color: 0xffa500, transparent: true, opacity: 0.55 });
const preview = new THREE.Mesh(/** @type {THREE.BufferGeometry} */ (new THREE.BoxGeometry()), previewMaterial);
preview.visible = false;
stage.add(preview);

/** Returns whether an item is being placed. */
export function isPlacing() {
  return pending !== null;
}

/** Returns the geometry of the preview. @param {Item} item */
function geometry({ form, size: [x, y, z] }) {
  if (form === "sphere") return new THREE.SphereGeometry(x / 2, 24, 12);
  if (form === "cylinder") return new THREE.CylinderGeometry(x / 2, x / 2, z, 24).rotateX(Math.PI / 2);
  if (form === "capsule") return new THREE.CapsuleGeometry(x / 2, z - x, 6, 16).rotateX(Math.PI / 2);
  return new THREE.BoxGeometry(x, y, z);
}

/**
 * Starts to place an item. If `dragged` is set, the mouse button is pressed, and the item is placed when it is
 * released; otherwise, the item is placed by the next click.
 * @param {Item} item
 * @param {boolean} dragged
 */
export function beginPlacement(item, dragged) {
  pending = { item, dragged };
  preview.geometry.dispose();
  preview.geometry = geometry(item);
  host.classList.add("placing");
  if (!dragged) host.focus({ preventScroll: true });
}

function endPlacement() {
  pending = null;
  preview.visible = false;
  controls.enabled = true;
  host.classList.remove("placing");
  redraw();
}

/**
 * Returns the point at which something would be placed, and the object there; null if there is no surface.
 * @param {Pointer} at
 */
function placeUnder(at) {
  const found = surfaceAt(at);
  if (!found) return null;
  const { x, y, z } = found.point;
  // Coordinates are rounded to 0.1 mm, because those of raycasts contain floating-point noise.
  const point = lengthStep() ? new THREE.Vector3(snapLength(x), snapLength(y), round(z)) : new THREE.Vector3(round(x), round(y), round(z));
  return { id: found.id, point };
}

/**
 * Returns the position at which an item would be placed, and the object there; null if there is no surface.
 * @param {Item} item
 * @param {Pointer} at
 */
function positionOver(item, at) {
  const found = placeUnder(at);
  return found && { id: found.id, point: found.point.setZ(round(found.point.z + item.lift)) };
}

/** Rounds a coordinate to 0.1 mm. @param {number} x m */
function round(x) {
  return Math.round(x * 1e4) / 1e4;
}

/**
 * Returns the object to which an item is attached: the object `id`, or 0 if it is a floor or has no parts.
 * @param {number} id
 */
function parentFor(id) {
  const o = scene.objects.get(id);
  return o?.parts?.some((p) => p.form !== "plane") ? id : 0;
}

/**
 * Returns the body to which a model is attached that is put on the object `id`: the nearest shape that collides, of those
 * that move together with the object. What one sees of a robot is often only a cover of its body.
 * @param {number} id
 */
function bodyFor(id) {
  for (let o = scene.objects.get(parentFor(id)); o?.kind === "shape"; o = scene.objects.get(o.parent)) if (o.collides) return o.id;
  return parentFor(id);
}

/**
 * Adds a script to a new model that has none: a wheeled robot gets one that drives it. Says so, or says that a robot
 * without wheels has no script.
 * @param {Item} item
 * @param {number} id
 * @param {string} label label of the edit
 * @param {string} merge
 */
async function addDriveScript(item, id, label, merge) {
  if (!item.isRobot) return;
  await whenPresent(id);
  if (subtree(id).some((below) => scene.objects.get(below)?.scripts?.length)) return;
  const name = scene.objects.get(id)?.alias ?? item.name;
  const [drive] = await call("tatu.get", id, "object.drive");
  if (drive?.type) {
    const text = await (await fetch("/page/edit/drive.lua")).text();
    await edit(label, [["tatu.addScript", id, text]], merge);
    writeLine("Status", t`${name} has a script that drives it around: double-click it to change the script`);
  } else writeLine("Status", t`${name} has no script: double-click it to write one`);
}

/**
 * Adds a model to the scene, with the origin of the model at a point. Sensors are attached to the body at this point.
 * @param {Item} item
 * @param {string} model the id of the model
 * @param {{ id: number, point: THREE.Vector3 }} found
 */
async function placeModel(item, model, found) {
  const { x, y, z } = found.point;
  const label = t`Add ${item.name}`;
  const merge = newMergeKey();
  const [[created] = []] = await edit(label, [["tatu.addModel", model]], merge);
  const [position] = await call("tatu.get", created, "object.position");
  await edit(label, [["tatu.set", created, "object.position", [x, y, round(position[2] + z)]]], merge);
  const parent = item.attach ? bodyFor(found.id) : 0;
  if (parent) {
    await edit(label, [["tatu.set", created, "object.parent", parent]], merge);
    writeLine("Status", t`${item.title ?? item.name} is attached to ${scene.objects.get(parent)?.alias ?? t`the body below it`}`);
  }
  try {
    await addDriveScript(item, created, label, merge);
  } finally {
    selectWhenPresent([created]);
  }
}

/**
 * Returns the place for a file that was dropped at a point of the page: under this point, or in the middle of the view if
 * the point is beside it; null if there is no surface.
 * @param {Pointer} at
 */
export function placeForFile(at) {
  return placeUnder(isInView(at) ? at : viewCenter());
}

/**
 * Returns the command call that puts a new object without a parent at a place. A model keeps its height above the ground;
 * of a mesh, whose file may have any origin, the lowest point is put there.
 * @param {number} id
 * @param {{ point: THREE.Vector3 }} place
 * @param {boolean} isMesh
 * @returns {[string, ...unknown[]]}
 */
export function placementCall(id, { point }, isMesh) {
  root.updateMatrixWorld(true);
  const [x = 0, y = 0, z = 0] = scene.objects.get(id)?.pose ?? [];
  if (!isMesh) return ["tatu.set", id, "object.position", [point.x, point.y, round(z + point.z)]];
  const box = boxOf(id);
  const middle = box.getCenter(new THREE.Vector3());
  return ["tatu.set", id, "object.position", [x + point.x - middle.x, y + point.y - middle.y, z + point.z - box.min.z].map(round)];
}

/**
 * Adds an item to the scene at the surface under the pointer.
 * @param {Item} item
 * @param {Pointer} at
 */
async function placeItem(item, at) {
  const found = positionOver(item, at);
  if (!found) return;
  const { x, y, z } = found.point;
  const label = t`Add ${item.name}`;
  const merge = newMergeKey();
  try {
    if (item.model) {
      await placeModel(item, item.model, found);
      return;
    }
    const [[created] = []] = await edit(label, [["tatu.add", item.toml, 0, [x, y, z]]], merge);
    const parent = item.attach ? parentFor(found.id) : 0;
    if (parent) await edit(label, [["tatu.set", created, "object.parent", parent]], merge);
    selectWhenPresent([created]);
  } catch (thrown) {
    reportError(thrown);
  }
}

/**
 * Places an item at the middle of the view.
 * @param {Item} item
 */
export function placeInMiddle(item) {
  return placeItem(item, viewCenter());
}

/** Returns whether the pointer is over the view. @param {Pointer} e */
function isInView(e) {
  return document.elementFromPoint(e.clientX, e.clientY)?.closest("#view") !== null;
}

addEventListener("pointermove", (e) => {
  if (!pending) return;
  const found = isInView(e) ? positionOver(pending.item, e) : null;
  preview.visible = found !== null;
  if (found) preview.position.copy(found.point);
  redraw();
}, true);
host.addEventListener("pointerdown", (e) => {
  // The camera must not move during the click that places the item.
  if (pending && e.button === 0) controls.enabled = false;
}, true);
addEventListener("pointerup", (e) => {
  if (!pending || e.button !== 0) return;
  const { item, dragged } = pending;
  const inside = isInView(e);
  if (!dragged && !inside) return;
  endPlacement();
  if (inside) placeItem(item, e);
}, true);
document.addEventListener("keydown", (e) => {
  if (!pending) return;
  if (e.key === "Escape") endPlacement();
  else if (e.key === "Enter") {
    const { item } = pending;
    endPlacement();
    placeInMiddle(item);
  } else return;
  e.preventDefault();
  e.stopPropagation();
}, true);
