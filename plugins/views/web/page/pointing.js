// @ts-check
// Determines which point of the scene is under the pointer.

import * as THREE from "three";
import { hitAt, host, rayAt } from "tatu/view";

/** @typedef {{ clientX: number, clientY: number }} Pointer */

/** @type {Pointer | null} */
let last = null;
host.addEventListener("pointermove", ({ clientX, clientY }) => { last = { clientX, clientY }; });
host.addEventListener("pointerleave", () => { last = null; });

/** Returns the position of the pointer while it is over the view, otherwise null. */
export function pointer() {
  return last;
}

/** Returns the position of the middle of the view. */
export function middle() {
  const box = host.getBoundingClientRect();
  return { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
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
