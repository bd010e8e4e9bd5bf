// @ts-check
// The 3-D view: camera, light, floor grid, and when a picture is drawn.

import * as THREE from "three";
import { OrbitControls } from "three/controls";
import { crowd, hitId, isLarge, place } from "tatu/crowd";
import { get } from "tatu/dom";
import { on } from "tatu/net";
import { bounds, groups, root } from "tatu/objects";
import { selected, selection, watch } from "tatu/store";

THREE.Object3D.DEFAULT_UP.set(0, 0, 1);
/** @import { ObjectGroup } from "tatu/crowd" */

export const host = get("view");
const dark = matchMedia("(prefers-color-scheme: dark)");

export const stage = new THREE.Scene();
export const camera = new THREE.PerspectiveCamera(50, 1, 0.02, 2000);
camera.up.set(0, 0, 1);
camera.position.set(3, -4, 2.5);
export const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
renderer.shadowMap.enabled = true;
renderer.shadowMap.type = THREE.PCFShadowMap;
host.append(renderer.domElement);
export const controls = new OrbitControls(camera, renderer.domElement);
controls.target.set(0, 0, 0.2);

const sun = new THREE.DirectionalLight(0xffffff, 2.2);
sun.castShadow = true;
sun.shadow.mapSize.set(2048, 2048);
stage.add(sun, sun.target, new THREE.HemisphereLight(0xffffff, 0x8d8d88, 1.5), root, crowd);
/** @type {THREE.GridHelper | null} */
let grid = null;

/**
 * The grid lies below what is there, a line for each metre.
 * @param {number} size
 */
function lay(size) {
  if (grid) stage.remove(grid);
  const n = Math.min(200, Math.max(10, 2 * Math.ceil(size)));
  grid = new THREE.GridHelper(n, n, dark.matches ? 0x5c6770 : 0x9aa3ad, dark.matches ? 0x343c44 : 0xd0d5da);
  grid.rotation.x = Math.PI / 2;
  grid.position.z = -0.001;
  stage.add(grid);
}

function paint() {
  stage.background = new THREE.Color(dark.matches ? 0x1b2026 : 0xe9edf2);
  redraw();
}
dark.addEventListener("change", paint);

let due = false;
/** Pictures that were drawn. */
export let drawn = 0;
/** Draws a picture soon. */
export function redraw() {
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    root.updateMatrixWorld();
    place(camera, renderer.domElement.height);
    // A graphics card draws shadows of thousands of parts, a processor does not.
    sun.castShadow = !isLarge();
    drawn++;
    renderer.render(stage, camera);
  });
}
controls.addEventListener("change", redraw);

new ResizeObserver(() => {
  const { clientWidth: w, clientHeight: h } = host;
  if (!w || !h) return;
  renderer.setSize(w, h);
  camera.aspect = w / h;
  camera.updateProjectionMatrix();
  redraw();
}).observe(host);

/**
 * Moves the camera so that everything, or these objects, are seen.
 * @param {THREE.Object3D[]} [objects]
 */
export function fit(objects) {
  const box = objects ? new THREE.Box3() : bounds();
  for (const object of objects ?? []) box.expandByObject(object);
  if (box.isEmpty()) return;
  const center = box.getCenter(new THREE.Vector3());
  const size = box.getSize(new THREE.Vector3()).length();
  // A robot alone needs room to drive, and a floor alone room to build on.
  const radius = Math.max(objects ? 0.1 : size > 0 ? 0.7 : 2.5, size / 2);
  const away = new THREE.Vector3(0.55, -0.75, 0.5).normalize();
  camera.position.copy(center).addScaledVector(away, radius / Math.sin((camera.fov * Math.PI) / 360));
  controls.target.copy(center);
  controls.update();
  lay(radius);
  light(center, radius);
  redraw();
}

/**
 * @param {THREE.Vector3} center
 * @param {number} radius
 */
function light(center, radius) {
  const r = Math.min(radius, 15);
  sun.position.set(center.x + r, center.y - 0.7 * r, center.z + 2 * r);
  sun.target.position.copy(center);
  Object.assign(sun.shadow.camera, { left: -1.5 * r, right: 1.5 * r, top: 1.5 * r, bottom: -1.5 * r, near: 0.01, far: 6 * r });
  sun.shadow.camera.updateProjectionMatrix();
  sun.shadow.normalBias = 0.02;
}

// Follow: the camera keeps its place beside the object.
const follow = get("follow");
/** @type {THREE.Vector3 | null} */
let last = null;
follow.onclick = () => {
  const is = follow.getAttribute("aria-pressed") !== "true";
  follow.setAttribute("aria-pressed", String(is));
  last = null;
};
on("frame", () => {
  const followed = groups.get(selected());
  if (follow.getAttribute("aria-pressed") === "true" && followed) {
    const here = followed.getWorldPosition(new THREE.Vector3());
    if (last) {
      const way = here.clone().sub(last);
      camera.position.add(way);
      controls.target.add(way);
      controls.update();
    }
    last = here;
  } else last = null;
  redraw();
});

/** Fits the selection, or everything, into the view. */
export function fitSelection() {
  const all = selection().flatMap((id) => groups.get(id) ?? []);
  fit(all.length ? all : undefined);
}
get("fit").onclick = fitSelection;
/**
 * Looks from where a camera of the scene does: along its z axis, to about the middle of what is there.
 * @param {ObjectGroup} group
 */
function lookFrom(group) {
  root.updateMatrixWorld(true);
  const box = bounds();
  const ahead = new THREE.Vector3(0, 0, 1).transformDirection(group.matrixWorld);
  const from = group.getWorldPosition(new THREE.Vector3());
  const center = box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3());
  const far = Math.max(0.5, center.clone().sub(from).dot(ahead));
  camera.position.copy(from);
  controls.target.copy(from).addScaledVector(ahead, far);
  controls.update();
  const radius = box.isEmpty() ? 5 : box.getSize(new THREE.Vector3()).length() / 2;
  lay(radius);
  light(controls.target.clone(), Math.min(radius, far));
  redraw();
}

watch("scene", (scene) => {
  // Another scene is seen from its own camera or as a whole; the same one is seen as before.
  const own = [...scene.objects.values()].find((o) => o.kind === "camera");
  if (scene.another) {
    requestAnimationFrame(() => {
      const group = groups.get(own?.id ?? 0);
      if (group) lookFrom(group);
      else fit();
    });
  }
  redraw();
});

watch("objects", redraw);

/**
 * The ray of a pointer.
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
 * The object below a pointer, and the point of it that is seen.
 * @param {{ clientX: number, clientY: number }} e
 */
export function hitAt(e) {
  const hit = rayAt(e).intersectObjects([root, crowd], true).find((h) => h.object instanceof THREE.Mesh && h.object.visible && hitId(h));
  return hit ? { id: hitId(hit), point: hit.point } : null;
}

/**
 * Where an object is in the world.
 * @param {number} id
 */
export function worldPosition(id) {
  const at = new THREE.Vector3();
  groups.get(id)?.getWorldPosition(at);
  return at;
}

lay(5);
paint();
