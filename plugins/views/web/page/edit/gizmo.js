// @ts-check
// Moves and rotates the selection by a gizmo with arrows and rings in the view, directly or by the joints above it.

import * as THREE from "three";
import { TransformControls } from "three/gizmo";
import { get } from "tatu/lib/dom";
import { t } from "tatu/lib/language";
import { compose, frameOf, inverse, positionOf, rotationAbout, translationAlong } from "tatu/lib/poses";
import { reason } from "tatu/net/calls";
import { on } from "tatu/net/connection";
import { isScriptsOnly } from "tatu/scene/edits";
import { writeLine } from "tatu/scene/messages";
import { rights, selected, watch } from "tatu/scene/store";
import { groups } from "tatu/view/objects";
import { camera, controls, redraw, renderer, stage } from "tatu/view/renderer";
import { GuideEdit } from "tatu/edit/guide_edit";
import { PoseEdit, movedObjects } from "tatu/edit/pose_edit";
import { angleStep, lengthStep, watchSnap } from "tatu/edit/snap_settings";

/** @import { Frame, Pose } from "tatu/lib/poses" */
/** @import { Quat } from "tatu/lib/rotations" */
/** @import { Vec3 } from "tatu/lib/vectors" */
/** @typedef {"translate" | "rotate"} Mode */

/**
 * The mode, or "" for none; the frame that defines the axes; the index of the only free axis, or -1 if all are free;
 * whether the joints above the object move it.
 */
export const moveTool = {
  mode: /** @type {Mode | ""} */ (""),
  frame: /** @type {Frame} */ ("world"),
  freeAxis: -1,
  guides: false,
};
/** Verbs for the labels of edits. */
export const EDIT_VERBS = { translate: t`Move`, rotate: t`Turn` };

/** @type {(() => void)[]} */
const watchers = [];
/**
 * Calls `f` when `moveTool` or the moved object changes.
 * @param {() => void} f
 */
export function watchMoveTool(f) {
  watchers.push(f);
}

/** Changes `moveTool`, and updates the gizmo and the buttons. @param {Partial<typeof moveTool>} change */
export function setMoveTool(change) {
  Object.assign(moveTool, change);
  updateGizmo();
}

/** Returns the object that the gizmo is attached to: the one selected last if a mode is active, otherwise 0. */
export function gizmoObject() {
  return moveTool.mode && rights.canControl && !isScriptsOnly() && groups.has(selected()) ? selected() : 0;
}

/**
 * Starts to move the selection, or to guide the object selected last by its joints.
 * @param {Mode} mode
 * @returns {Promise<PoseEdit | GuideEdit>}
 */
export function beginEdit(mode) {
  return moveTool.guides ? GuideEdit.begin(gizmoObject()) : PoseEdit.begin(EDIT_VERBS[mode], movedObjects());
}

/** The error that was shown last; a drag that goes on failing for the same reason shows it once. */
let shownError = "";
/** Shows an error in the status line. @param {unknown} thrown */
export function showError(thrown) {
  if (reason(thrown) !== shownError) writeLine("Status", reason(thrown), "error");
  shownError = reason(thrown);
}

// The gizmo is attached to a handle in the chosen frame, because it does not support the frame of a parent.
const anchor = new THREE.Group();
const handle = new THREE.Object3D();
anchor.add(handle);
const gizmo = new TransformControls(camera, renderer.domElement);
gizmo.setSpace("local");
gizmo.setColors(0xe5484d, 0x30a46c, 0x3e63dd, 0xffb224);
gizmo.setSize(0.8);
stage.add(anchor, gizmo.getHelper());
/** @type {[Mode, HTMLElement][]} */
const buttons = [["translate", get("move")], ["rotate", get("turn")]];

const guide = get("guide");

/**
 * The current drag, with the initial position of the handle. `edit` is a promise, because the program must be asked
 * for the exact poses.
 * @type {{ mode: Mode, start: Vec3, edit: Promise<PoseEdit | GuideEdit> } | null}
 */
let drag = null;

/** Returns the pose of a three.js object in the world frame. @param {THREE.Object3D} object @returns {Pose} */
function worldPose(object) {
  object.updateWorldMatrix(true, false);
  const [p, q] = [new THREE.Vector3(), new THREE.Quaternion()];
  object.matrixWorld.decompose(p, q, new THREE.Vector3());
  return [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
}

/** Sets the pose of a three.js object in its parent's frame. @param {THREE.Object3D} object @param {Pose} pose */
function setPose(object, pose) {
  object.position.fromArray(pose);
  object.quaternion.fromArray(pose, 3);
}

/** Moves the handle to the selected object, except during a drag. */
function placeHandle() {
  const group = groups.get(gizmoObject());
  if (!group || drag) return;
  const world = worldPose(group);
  const parent = group.parent ? worldPose(group.parent) : null;
  const frame = frameOf(moveTool.frame, { world, local: parent ? compose(inverse(parent), world) : world });
  setPose(anchor, frame);
  setPose(handle, [...positionOf(compose(inverse(frame), world)), 0, 0, 0, 1]);
}

/** Shows the gizmo and the buttons as `moveTool` requires. */
function updateGizmo() {
  const { mode, freeAxis } = moveTool;
  if (mode && gizmoObject()) {
    placeHandle();
    gizmo.setMode(mode);
    gizmo.attach(handle);
    for (const [i, key] of /** @type {const} */ (["showX", "showY", "showZ"]).entries()) gizmo[key] = freeAxis < 0 || freeAxis === i;
    gizmo.translationSnap = lengthStep() || null;
    gizmo.rotationSnap = angleStep() || null;
  } else gizmo.detach();
  for (const [m, b] of buttons) b.setAttribute("aria-pressed", String(m === mode));
  guide.setAttribute("aria-pressed", String(moveTool.guides));
  for (const f of watchers) f();
  redraw();
}

for (const [m, b] of buttons) b.onclick = () => setMoveTool({ mode: moveTool.mode === m ? "" : m, freeAxis: -1 });
// Guiding is of use only with arrows or rings.
guide.onclick = () => setMoveTool({ guides: !moveTool.guides, mode: moveTool.mode || "translate" });
watch("selected", updateGizmo);
watch("scene", updateGizmo);
watchSnap(updateGizmo);
on("hello", updateGizmo);
on("frame", placeHandle);
gizmo.addEventListener("change", redraw);
gizmo.addEventListener("dragging-changed", (e) => {
  controls.enabled = !e.value;
  shownError = "";
  if (e.value && moveTool.mode) {
    const { x, y, z } = handle.position;
    drag = { mode: moveTool.mode, start: [x, y, z], edit: beginEdit(moveTool.mode) };
    drag.edit.catch(showError);
  } else {
    drag = null;
    placeHandle();
  }
});

/**
 * Returns the displacement of the handle along the axes of its frame. If a grid is set, it is the displacement that
 * moves the object from its exact position to a point of the grid.
 * @param {Vec3} start initial position of the handle
 * @param {Vec3} exact initial position of the object
 * @returns {Vec3}
 */
function displacement(start, exact) {
  const current = handle.position.toArray();
  const component = (/** @type {0 | 1 | 2} */ i) => {
    if (Math.abs(current[i] - start[i]) < 1e-9) return 0;
    return current[i] - (lengthStep() ? exact[i] : start[i]);
  };
  return [component(0), component(1), component(2)];
}

gizmo.addEventListener("objectChange", () => {
  if (!drag) return;
  const { mode, start, edit } = drag;
  const [id, q] = [gizmoObject(), handle.quaternion.clone().normalize()];
  edit.then((poseEdit) => {
    const initial = poseEdit.initialPoses(id);
    if (!initial) return;
    const frame = frameOf(moveTool.frame, initial);
    /** @type {Quat} */
    const turn = [q.x, q.y, q.z, q.w];
    const exact = positionOf(compose(inverse(frame), initial.world));
    return poseEdit.apply(mode === "translate" ? translationAlong(frame, displacement(start, exact)) : rotationAbout(frame, turn, positionOf(initial.world)));
  }).then(() => { shownError = ""; }, showError);
});
