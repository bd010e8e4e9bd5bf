// @ts-check
// Controls the camera by buttons and keys: fits the scene into the view, selects standard views and parallel
// projection, and follows objects.

import * as THREE from "three";
import { get, make } from "tatu/lib/dom";
import { t } from "tatu/lib/language";
import { on } from "tatu/net/connection";
import { selected, selection, watch } from "tatu/scene/store";
import { groups } from "tatu/view/objects";
import { hitAt } from "tatu/view/picking";
import { camera, controls, fit, host, redraw, renderer } from "tatu/view/renderer";

/** Fits the selected objects into the view, or the scene if none are selected. */
export function fitSelection() {
  const all = selection().flatMap((id) => groups.get(id) ?? []);
  fit(all.length ? all : undefined);
}
get("fit").onclick = fitSelection;

/** Names of the standard views and directions towards the camera, by digit key. In "Top", y points up on the screen. */
const VIEWS = /** @type {const} */ ({
  1: [t`Front`, [1, 0, 0]], 2: [t`Back`, [-1, 0, 0]], 3: [t`Left`, [0, 1, 0]], 4: [t`Right`, [0, -1, 0]],
  5: [t`Top`, [0, -1e-4, 1]], 6: [t`Bottom`, [0, -1e-4, -1]], 7: [t`Corner`, [-0.55, -0.65, 0.5]],
});

/**
 * Moves the camera around its target to a direction, at the same distance.
 * @param {readonly [number, number, number] | readonly number[]} direction
 */
function lookAlong(direction) {
  const far = camera.position.distanceTo(controls.target);
  const [x = 0, y = 0, z = 1] = direction;
  camera.position.copy(controls.target).addScaledVector(new THREE.Vector3(x, y, z).normalize(), far);
  controls.update();
  redraw();
}

// Parallel projection is approximated by a distant camera with a narrow field of view.
/** Field of view with perspective, degrees. */
const PERSPECTIVE_ANGLE = 50;
/** Field of view for parallel projection, degrees. */
const PARALLEL_ANGLE = 1.5;
const parallelButton = get("flat");
parallelButton.onclick = () => {
  const isOn = parallelButton.getAttribute("aria-pressed") !== "true";
  parallelButton.setAttribute("aria-pressed", String(isOn));
  const half = (/** @type {number} */ angle) => Math.tan((angle * Math.PI) / 360);
  const fov = isOn ? PARALLEL_ANGLE : PERSPECTIVE_ANGLE;
  const away = camera.position.clone().sub(controls.target).multiplyScalar(half(camera.fov) / half(fov));
  camera.fov = fov;
  camera.position.copy(controls.target).add(away);
  camera.updateProjectionMatrix();
  controls.update();
  redraw();
};

// While the camera follows an object, it keeps its position relative to the object and rotates with its heading.
const followButton = get("follow");
/**
 * Position and heading (rad) of the followed object in the last frame.
 * @type {{ at: THREE.Vector3, heading: number } | null}
 */
let lastPose = null;
/** Handle of the followed object; it does not change when another object is selected. 0: none. */
let followed = 0;
/** @param {boolean} isOn */
function setFollow(isOn) {
  followButton.setAttribute("aria-pressed", String(isOn));
  followed = isOn ? selected() : 0;
  lastPose = null;
  if (followed) lookAt(followed);
  follow();
}

/** Moves the camera so that it looks at an object, from the same direction and distance. @param {number} id */
function lookAt(id) {
  const group = groups.get(id);
  if (!group) return;
  group.updateWorldMatrix(true, false);
  const displacement = group.getWorldPosition(new THREE.Vector3()).sub(controls.target);
  controls.target.add(displacement);
  camera.position.add(displacement);
  controls.update();
  redraw();
}
/** Lets the camera follow the selected object. */
export const followSelection = () => setFollow(true);
followButton.onclick = () => setFollow(followButton.getAttribute("aria-pressed") !== "true");
watch("scene", () => { if (followed && !groups.has(followed)) setFollow(false); });

const ahead = new THREE.Vector3();
/**
 * Returns the heading of an object's x axis, rad, or `fallback` if the axis is nearly vertical.
 * @param {THREE.Object3D} object
 * @param {number} fallback
 */
function headingOf(object, fallback) {
  ahead.set(1, 0, 0).transformDirection(object.matrixWorld);
  return Math.hypot(ahead.x, ahead.y) > 0.2 ? Math.atan2(ahead.y, ahead.x) : fallback;
}

/** Moves the camera with the followed object. */
function follow() {
  if (followButton.getAttribute("aria-pressed") === "true") {
    if (!followed && selected()) {
      followed = selected();
      lookAt(followed);
    }
    const group = groups.get(followed);
    if (group) {
      group.updateWorldMatrix(true, false);
      const at = group.getWorldPosition(new THREE.Vector3());
      const heading = headingOf(group, lastPose?.heading ?? 0);
      if (lastPose) {
        const displacement = at.clone().sub(lastPose.at);
        const turn = heading - lastPose.heading;
        const vertical = new THREE.Vector3(0, 0, 1);
        for (const point of [camera.position, controls.target]) point.add(displacement).sub(at).applyAxisAngle(vertical, turn).add(at);
        controls.update();
      }
      lastPose = { at, heading };
    }
  } else lastPose = null;
}
on("frame", follow);
watch("selected", follow);

// A double click moves the point under the pointer to the centre of the view.
renderer.domElement.addEventListener("dblclick", (e) => {
  const hit = hitAt(e);
  if (!hit) return;
  const displacement = hit.point.clone().sub(controls.target);
  controls.target.add(displacement);
  camera.position.add(displacement);
  controls.update();
  redraw();
});

/** Angle by which a key rotates the camera, rad. */
const ROTATION_STEP = Math.PI / 24;
/** Distance by which a key moves the camera, as a fraction of the height of the view. */
const PAN_FRACTION = 0.06;
/** Factor by which a key changes the distance of the camera from its target. */
const ZOOM_FACTOR = 1.15;
/**
 * Rotates, moves or zooms the camera by a key that is pressed with Alt. Returns false for other keys.
 * @param {KeyboardEvent} e
 */
function moveByKey(e) {
  const away = camera.position.clone().sub(controls.target);
  const sideways = { ArrowLeft: -1, ArrowRight: 1 }[e.key] ?? 0;
  const upward = { ArrowUp: 1, ArrowDown: -1 }[e.key] ?? 0;
  const right = new THREE.Vector3().setFromMatrixColumn(camera.matrix, 0);
  if (sideways || upward) {
    if (e.shiftKey) {
      const up = new THREE.Vector3().setFromMatrixColumn(camera.matrix, 1);
      const reach = PAN_FRACTION * away.length() * Math.tan((camera.fov * Math.PI) / 360) * 2;
      const displacement = right.multiplyScalar(sideways * reach).addScaledVector(up, upward * reach);
      controls.target.add(displacement);
    } else {
      away.applyAxisAngle(new THREE.Vector3(0, 0, 1), sideways * ROTATION_STEP);
      const tilt = Math.acos(Math.min(1, Math.max(-1, away.z / away.length())));
      const next = Math.min(Math.PI - 0.02, Math.max(0.02, tilt - upward * ROTATION_STEP));
      away.applyAxisAngle(new THREE.Vector3(0, 0, 1).cross(away).normalize(), next - tilt);
    }
  } else if (e.key === "+" || e.key === "=") away.divideScalar(ZOOM_FACTOR);
  else if (e.key === "-") away.multiplyScalar(ZOOM_FACTOR);
  else return false;
  camera.position.copy(controls.target).add(away);
  controls.update();
  redraw();
  return true;
}

host.addEventListener("keydown", (e) => {
  if (!e.altKey || e.ctrlKey || e.metaKey) return;
  const view = VIEWS[/** @type {keyof typeof VIEWS} */ (Number(e.code.replace("Digit", "")))];
  if (view) lookAlong(view[1]);
  else if (!moveByKey(e)) return;
  e.preventDefault();
  e.stopPropagation();
});

const views = get("views", HTMLSelectElement);
for (const [key, [name]] of Object.entries(VIEWS)) views.append(make("option", { value: key, textContent: `${name} (Alt+${key})` }));
views.onchange = () => {
  const view = VIEWS[/** @type {keyof typeof VIEWS} */ (Number(views.value))];
  if (view) lookAlong(view[1]);
  views.value = "";
};
