// @ts-check
// Moves and rotates the selection by keys while the view has the focus.

import * as THREE from "three";
import { get } from "tatu/lib/dom";
import { frameOf, positionOf, rotationAbout, rotationOf, translationAlong } from "tatu/lib/poses";
import { axisRotation, multiply, screenAxes } from "tatu/lib/rotations";
import { rights, selected } from "tatu/scene/store";
import { camera } from "tatu/view/renderer";
import { beginEdit, gizmoObject, moveTool, setMoveTool, showError } from "tatu/edit/gizmo";
import { movedObjects } from "tatu/edit/pose_edit";
import { angleStep, lengthStep } from "tatu/edit/snap_settings";

/** @import { GuideEdit } from "tatu/edit/guide_edit" */
/** @import { PoseEdit } from "tatu/edit/pose_edit" */
/** @import { Quat, AxisDirection } from "tatu/lib/rotations" */
/** @import { Vec3 } from "tatu/lib/vectors" */

/** Steps per key press if no grid or angle is set, m and degrees. */
export const STEPS = { translate: 0.05, rotate: 5 };
/** Factor of the steps with Shift. */
export const FINE_FACTOR = 0.1;

/** Returns the step per key press, m or degrees; `fine` is whether Shift is pressed. */
export function keyStep(fine = false) {
  const coarse = moveTool.mode === "rotate" ? (angleStep() * 180) / Math.PI || STEPS.rotate : lengthStep() || STEPS.translate;
  return Number((coarse * (fine ? FINE_FACTOR : 1)).toPrecision(12));
}

/** Returns the components of a vector. @param {THREE.Vector3} v @returns {Vec3} */
const numbers = (v) => [v.x, v.y, v.z];

/**
 * Returns the axis of a frame along or about which a key moves the selection, and the sign of the motion.
 * @param {string} key
 * @param {Quat} frame
 * @returns {AxisDirection | null}
 */
function directionOf(key, frame) {
  camera.updateMatrixWorld();
  const [right, up] = [new THREE.Vector3(), new THREE.Vector3()];
  camera.matrixWorld.extractBasis(right, up, new THREE.Vector3());
  const away = numbers(up.add(camera.getWorldDirection(new THREE.Vector3())));
  const { across, ahead } = screenAxes(frame, numbers(right), away);
  const sign = key === "ArrowRight" || key === "ArrowUp" || key === "PageUp" ? 1 : -1;
  const vertical = key.startsWith("Page");
  const sideways = key === "ArrowLeft" || key === "ArrowRight";
  if (moveTool.mode === "rotate") {
    // The left arrow key rotates counterclockwise as seen from above; the up key tilts the object away from the camera.
    const direction = vertical || sideways ? { axis: 2, sign: vertical ? sign : -sign } : { axis: across.axis, sign: -sign * across.sign };
    return moveTool.freeAxis < 0 ? direction : { axis: moveTool.freeAxis, sign: direction.sign };
  }
  const direction = vertical ? { axis: 2, sign: 1 } : sideways ? across : ahead;
  if (moveTool.freeAxis < 0 || moveTool.freeAxis === direction.axis) return { axis: direction.axis, sign: sign * direction.sign };
  // If the free axis is one of the horizontal axes, its sign is chosen so that the motion follows the screen.
  const free = [across, ahead].find(({ axis }) => axis === moveTool.freeAxis) ?? { axis: moveTool.freeAxis, sign: 1 };
  return { axis: free.axis, sign: sign * free.sign };
}

/**
 * The combined motion of all key presses until a key is released, which forms a single edit. `identity` identifies the
 * mode, the frame and the objects.
 * @typedef {{ identity: string, by: Vec3, turn: Quat, edit: Promise<PoseEdit | GuideEdit> }} KeyMotion
 */
/** @type {KeyMotion | null} */
let keyMotion = null;
/** Settled when the last motion has been applied; only then can exact poses be requested. @type {Promise<unknown>} */
let lastMotion = Promise.resolve();

/**
 * Moves or rotates the selection by one step.
 * @param {string} key
 * @param {boolean} fine whether Shift is pressed
 */
function moveByKey(key, fine) {
  const { mode, frame: frameName } = moveTool;
  const id = gizmoObject();
  if (!mode) return;
  const ids = movedObjects();
  const identity = [mode, frameName, moveTool.guides, ...ids].join();
  if (keyMotion?.identity !== identity) keyMotion = { identity, by: [0, 0, 0], turn: [0, 0, 0, 1], edit: lastMotion.then(() => beginEdit(mode)) };
  const motion = keyMotion;
  lastMotion = motion.edit.then((poseEdit) => {
    const initial = poseEdit.initialPoses(id);
    if (!initial) return;
    const frame = frameOf(frameName, initial);
    const direction = directionOf(key, rotationOf(frame));
    if (!direction) return;
    const amount = direction.sign * keyStep(fine);
    if (mode === "rotate") motion.turn = multiply(axisRotation(direction.axis, amount), motion.turn);
    else motion.by[direction.axis] = (motion.by[direction.axis] ?? 0) + amount;
    return poseEdit.apply(mode === "rotate" ? rotationAbout(frame, motion.turn, positionOf(initial.world)) : translationAlong(frame, motion.by));
  }).catch(showError);
}

const MOTION_KEYS = new Set(["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "PageUp", "PageDown"]);
const view = get("view");

/**
 * Handles a key press. Returns false if the key is not handled here.
 * @param {KeyboardEvent} e
 */
function handleKey(e) {
  const key = e.key.length === 1 ? e.key.toLowerCase() : e.key;
  if ((key === "g" || key === "r") && !e.shiftKey && selected()) {
    const mode = key === "g" ? "translate" : "rotate";
    if (!e.repeat) setMoveTool({ mode: moveTool.mode === mode ? "" : mode, freeAxis: -1 });
    return true;
  }
  if (!gizmoObject()) return false;
  if (MOTION_KEYS.has(key)) moveByKey(key, e.shiftKey);
  else if (key === "Escape") setMoveTool({ mode: "", freeAxis: -1 });
  else if (key.length === 1 && "xyz".includes(key)) {
    const axis = "xyz".indexOf(key);
    if (!e.repeat) setMoveTool({ freeAxis: moveTool.freeAxis === axis ? -1 : axis });
  } else return false;
  return true;
}

// Registered for the capture phase, so that the simulation and the selected robot receive only keys not handled here.
addEventListener("keydown", (e) => {
  if (e.target !== view || e.ctrlKey || e.metaKey || e.altKey || !rights.canControl || !handleKey(e)) return;
  e.preventDefault();
  e.stopImmediatePropagation();
}, true);
addEventListener("keyup", (e) => { if (MOTION_KEYS.has(e.key)) keyMotion = null; }, true);
