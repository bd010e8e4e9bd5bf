// @ts-check
// Determines which point of the scene is under the pointer.

import * as THREE from "three";
import { hitId, instancedGroup } from "tatu/view/instancing";
import { groups, root } from "tatu/view/objects";
import { camera, host, renderer } from "tatu/view/renderer";

/** @typedef {{ clientX: number, clientY: number }} Pointer */

/** @type {Pointer | null} */
let lastPointer = null;
host.addEventListener("pointermove", ({ clientX, clientY }) => { lastPointer = { clientX, clientY }; });
host.addEventListener("pointerleave", () => { lastPointer = null; });

/** Returns the position of the pointer while it is over the view, otherwise null. */
export function pointer() {
  return lastPointer;
}

/** Returns the position of the middle of the view. */
export function viewCenter() {
  const box = host.getBoundingClientRect();
  return { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
}

/**
 * Returns the ray through the pointer.
 * @param {{ clientX: number, clientY: number }} e
 */
export function rayAt(e) {
  const box = renderer.domElement.getBoundingClientRect();
  const at = new THREE.Vector2(((e.clientX - box.left) / box.width) * 2 - 1, 1 - ((e.clientY - box.top) / box.height) * 2);
  const ray = new THREE.Raycaster();
  ray.setFromCamera(at, camera);
  return ray;
}

/**
 * Returns the object under the pointer and the point on its surface, or null.
 * @param {{ clientX: number, clientY: number }} e
 */
export function hitAt(e) {
  const hit = rayAt(e).intersectObjects([root, instancedGroup], true).find((h) => h.object instanceof THREE.Mesh && h.object.visible && hitId(h));
  return hit ? { id: hitId(hit), point: hit.point } : null;
}

const floor = new THREE.Plane(new THREE.Vector3(0, 0, 1), 0);

/**
 * Returns the point under the pointer, which is on the surface of the object `id`, or on the ground (z = 0) if `id` is
 * 0. Returns null if there is neither.
 * @param {Pointer | null} at
 * @returns {{ id: number, point: THREE.Vector3 } | null}
 */
export function surfaceAt(at) {
  if (!at) return null;
  const hit = hitAt(at);
  if (hit) return hit;
  const point = rayAt(at).ray.intersectPlane(floor, new THREE.Vector3());
  return point && point.length() < 1000 ? { id: 0, point } : null;
}

/**
 * Returns the point under the pointer, as `surfaceAt` does, but without the object.
 * @param {Pointer | null} at
 */
export function groundAt(at) {
  return at ? surfaceAt(at)?.point ?? null : null;
}

/**
 * Returns the position of an object in the world frame.
 * @param {number} id
 */
export function worldPosition(id) {
  const at = new THREE.Vector3();
  groups.get(id)?.getWorldPosition(at);
  return at;
}
