// @ts-check
// Aligns, distributes and assembles the selected objects.

import * as THREE from "three";
import { get, make } from "tatu/lib/dom";
import { t } from "tatu/lib/language";
import { describeObjects, edit } from "tatu/scene/edits";
import { isBelow, topmost } from "tatu/scene/hierarchy";
import { reportError } from "tatu/scene/messages";
import { rights, scene, selected, selection, watch } from "tatu/scene/store";
import { groups, root } from "tatu/view/objects";
import { host } from "tatu/view/renderer";
import { reparent } from "tatu/edit/object_actions";

/** @typedef {"x" | "y" | "z"} Axis */

/**
 * Returns the bounding box of an object and all objects below it, in the world frame. If they have no parts, the box
 * contains only the position of the object.
 * @param {number} id
 */
export function boxOf(id) {
  const group = groups.get(id);
  const box = new THREE.Box3();
  if (!group) return box;
  box.setFromObject(group);
  if (box.isEmpty()) box.expandByPoint(group.getWorldPosition(new THREE.Vector3()));
  return box;
}

/**
 * Returns the command call that moves an object by a vector in the world frame.
 * @param {number} id
 * @param {THREE.Vector3} by
 * @returns {[string, ...unknown[]]}
 */
function moveCall(id, by) {
  const group = groups.get(id);
  const at = group?.position.clone() ?? new THREE.Vector3();
  const turn = group?.parent?.getWorldQuaternion(new THREE.Quaternion()) ?? new THREE.Quaternion();
  at.add(by.clone().applyQuaternion(turn.invert()));
  // Rounding removes floating-point noise, which would otherwise appear in the scene file.
  return ["tatu.set", id, "object.position", at.toArray().map((x) => Number(x.toFixed(6)) + 0)];
}

/**
 * Moves each selected object by the vector that `displacement` returns for its bounding box and index.
 * @param {string} word verb for the label of the edit
 * @param {(box: THREE.Box3, i: number) => THREE.Vector3} displacement
 */
async function moveEach(word, displacement) {
  root.updateMatrixWorld(true);
  const ids = topmost(selection());
  const moves = ids.map((id, i) => ({ id, by: displacement(boxOf(id), i) })).filter(({ by }) => by.length() > 1e-9);
  if (!moves.length) return;
  await edit(`${word} ${describeObjects(ids)}`, moves.map(({ id, by }) => moveCall(id, by))).catch(reportError);
}

/** Returns a vector of length `x` along an axis. @param {Axis} axis @param {number} x */
function along(axis, x) {
  return new THREE.Vector3().setComponent("xyz".indexOf(axis), x);
}

/**
 * Aligns the lower sides, middles or upper sides of the selected objects with that of the object selected last.
 * @param {Axis} axis
 * @param {number} part 0: lower side; 0.5: middle; 1: upper side
 */
function align(axis, part) {
  root.updateMatrixWorld(true);
  const side = (/** @type {THREE.Box3} */ box) => box.min[axis] + part * (box.max[axis] - box.min[axis]);
  const goal = side(boxOf(selected()));
  return moveEach(t`Align`, (box) => along(axis, goal - side(box)));
}

/** Moves each selected object vertically so that its lowest point is at z = 0. */
function putOnGround() {
  return moveEach(t`Put down`, (box) => along("z", -box.min.z));
}

/**
 * Distributes the centres of the selected objects evenly between the two outermost ones.
 * @param {Axis} axis
 */
function distribute(axis) {
  root.updateMatrixWorld(true);
  const centerOf = (/** @type {number} */ id) => boxOf(id).getCenter(new THREE.Vector3())[axis];
  const sorted = topmost(selection()).map((id) => ({ id, at: centerOf(id) })).sort((a, b) => a.at - b.at);
  const [low, high] = [sorted[0]?.at ?? 0, sorted.at(-1)?.at ?? 0];
  const positions = new Map(sorted.map(({ id }, i) => [id, low + (i * (high - low)) / Math.max(1, sorted.length - 1)]));
  const ids = topmost(selection());
  return moveEach(t`Distribute`, (box, i) => along(axis, (positions.get(ids[i] ?? 0) ?? 0) - box.getCenter(new THREE.Vector3())[axis]));
}

/** Attaches the second selected object to the first one without moving it. */
function assemble() {
  const [base, part] = selection();
  if (base === undefined || part === undefined || isBelow(base, part)) return;
  return reparent([part], base);
}

const bar = get("arrange");
const axis = make("select", { title: t`Axis` });
axis.setAttribute("aria-label", t`Axis`);
for (const name of ["x", "y", "z"]) axis.add(new Option(name, name));
const chosenAxis = () => /** @type {Axis} */ (axis.value);

/**
 * Adds a button to the toolbar.
 * @param {string} id
 * @param {string} name
 * @param {string} title
 * @param {() => unknown} action
 */
function button(id, name, title, action) {
  const b = make("button", { id, textContent: name, title, onclick: () => { action(); } });
  bar.append(b);
  return b;
}

bar.append(make("span", { textContent: t`Align` }), axis);
button("align-low", t`low`, t`Align the lower sides along the axis to those of the object selected last`, () => align(chosenAxis(), 0));
button("align-middle", t`middle`, t`Align the middles along the axis`, () => align(chosenAxis(), 0.5));
button("align-high", t`high`, t`Align the upper sides along the axis`, () => align(chosenAxis(), 1));
button("spread", t`distribute`, t`Distribute the centres evenly along the axis`, () => distribute(chosenAxis()));
button("ground", t`to the ground`, t`Move the lowest point of each object to height 0`, putOnGround);
const assembleButton = button("assemble", t`assemble`, t`Attach the object selected last to the one selected first without moving it`, assemble);

function updateToolbar() {
  const count = selection().length;
  bar.hidden = !rights.canControl || count < 2;
  assembleButton.disabled = count !== 2 || scene.objects.get(selection()[1] ?? 0)?.parent === selection()[0];
}
watch("selected", updateToolbar);
watch("scene", updateToolbar);
watch("objects", updateToolbar);
host.append(bar);
