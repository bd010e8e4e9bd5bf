// @ts-check
// Moves and rotates the selection by keys while the view has the focus.

import * as THREE from "three";
import { get } from "tatu/lib/dom";
import { frameOf, positionOf, rotationOf, shift, spin } from "tatu/lib/poses";
import { about, multiply, screenAxes } from "tatu/lib/rotations";
import { rights, selected } from "tatu/scene/store";
import { camera } from "tatu/view/renderer";
import { VERB, how, pivot, report, setHow } from "tatu/edit/gizmo";
import { Carry, carried } from "tatu/edit/pose_edit";
import { angleStep, lengthStep } from "tatu/edit/snap_settings";

/** @import { Quat, Way } from "tatu/lib/rotations" */
/** @import { Vec3 } from "tatu/lib/vectors" */

/** Steps per key press if no grid or angle is set, m and degrees. */
export const STEPS = { translate: 0.05, rotate: 5 };
/** Factor of the steps with Shift. */
export const FINE = 0.1;

/** Returns the step per key press, m or degrees; `fine` is whether Shift is pressed. */
export function step(fine = false) {
  const whole = how.mode === "rotate" ? (angleStep() * 180) / Math.PI || STEPS.rotate : lengthStep() || STEPS.translate;
  return Number((whole * (fine ? FINE : 1)).toPrecision(12));
}

/** Returns the components of a vector. @param {THREE.Vector3} v @returns {Vec3} */
const numbers = (v) => [v.x, v.y, v.z];

/**
 * Returns the axis of a frame along or about which a key moves the selection, and the sign of the motion.
 * @param {string} key
 * @param {Quat} frame
 * @returns {Way | null}
 */
function wayOf(key, frame) {
  camera.updateMatrixWorld();
  const [right, up] = [new THREE.Vector3(), new THREE.Vector3()];
  camera.matrixWorld.extractBasis(right, up, new THREE.Vector3());
  const away = numbers(up.add(camera.getWorldDirection(new THREE.Vector3())));
  const { across, ahead } = screenAxes(frame, numbers(right), away);
  const sign = key === "ArrowRight" || key === "ArrowUp" || key === "PageUp" ? 1 : -1;
  const vertical = key.startsWith("Page");
  const sideways = key === "ArrowLeft" || key === "ArrowRight";
  if (how.mode === "rotate") {
    // The left arrow key rotates counterclockwise as seen from above; the up key tilts the object away from the camera.
    const way = vertical || sideways ? { axis: 2, sign: vertical ? sign : -sign } : { axis: across.axis, sign: -sign * across.sign };
    return how.only < 0 ? way : { axis: how.only, sign: way.sign };
  }
  const way = vertical ? { axis: 2, sign: 1 } : sideways ? across : ahead;
  if (how.only < 0 || how.only === way.axis) return { axis: way.axis, sign: sign * way.sign };
  // If the free axis is one of the horizontal axes, its sign is chosen so that the motion follows the screen.
  const free = [across, ahead].find(({ axis }) => axis === how.only) ?? { axis: how.only, sign: 1 };
  return { axis: free.axis, sign: sign * free.sign };
}

/**
 * The combined motion of all key presses until a key is released, which forms a single edit. `of` identifies the mode,
 * the frame and the objects.
 * @typedef {{ of: string, by: Vec3, turn: Quat, carry: Promise<Carry> }} Burst
 */
/** @type {Burst | null} */
let burst = null;
/** Settled when the last motion has been applied; only then can exact poses be requested. @type {Promise<unknown>} */
let before = Promise.resolve();

/**
 * Moves or rotates the selection by one step.
 * @param {string} key
 * @param {boolean} fine whether Shift is pressed
 */
function nudge(key, fine) {
  const { mode, frame: frameName } = how;
  const id = pivot();
  if (!mode) return;
  const ids = carried();
  const of = [mode, frameName, ...ids].join();
  if (burst?.of !== of) burst = { of, by: [0, 0, 0], turn: [0, 0, 0, 1], carry: before.then(() => Carry.take(VERB[mode], ids)) };
  const own = burst;
  before = own.carry.then((carry) => {
    const place = carry.from(id);
    if (!place) return;
    const frame = frameOf(frameName, place);
    const way = wayOf(key, rotationOf(frame));
    if (!way) return;
    const amount = way.sign * step(fine);
    if (mode === "rotate") own.turn = multiply(about(way.axis, amount), own.turn);
    else own.by[way.axis] = (own.by[way.axis] ?? 0) + amount;
    return carry.put(mode === "rotate" ? spin(frame, own.turn, positionOf(place.world)) : shift(frame, own.by));
  }).catch(report);
}

const NUDGES = new Set(["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "PageUp", "PageDown"]);
const view = get("view");

/**
 * Handles a key press. Returns false if the key is not handled here.
 * @param {KeyboardEvent} e
 */
function act(e) {
  const key = e.key.length === 1 ? e.key.toLowerCase() : e.key;
  if ((key === "g" || key === "r") && !e.shiftKey && selected()) {
    const mode = key === "g" ? "translate" : "rotate";
    if (!e.repeat) setHow({ mode: how.mode === mode ? "" : mode, only: -1 });
    return true;
  }
  if (!pivot()) return false;
  if (NUDGES.has(key)) nudge(key, e.shiftKey);
  else if (key === "Escape") setHow({ mode: "", only: -1 });
  else if (key.length === 1 && "xyz".includes(key)) {
    const axis = "xyz".indexOf(key);
    if (!e.repeat) setHow({ only: how.only === axis ? -1 : axis });
  } else return false;
  return true;
}

// Registered for the capture phase, so that the simulation and the selected robot receive only keys not handled here.
addEventListener("keydown", (e) => {
  if (e.target !== view || e.ctrlKey || e.metaKey || e.altKey || !rights.acts || !act(e)) return;
  e.preventDefault();
  e.stopImmediatePropagation();
}, true);
addEventListener("keyup", (e) => { if (NUDGES.has(e.key)) burst = null; }, true);
