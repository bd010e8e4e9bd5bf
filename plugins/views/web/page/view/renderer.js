// @ts-check
// The 3-D view: renders the scene on demand, and manages the camera and shadows.

import * as THREE from "three";
import { OrbitControls } from "three/controls";
import { get } from "tatu/lib/dom";
import { hasMotion } from "tatu/net/binary_messages";
import { on } from "tatu/net/connection";
import { scene, watch } from "tatu/scene/store";
import { instancedGroup, isLarge, updateInstances } from "tatu/view/instancing";
import { LAMP, dome, floor, onThemeChange, placeFloor, zoom } from "tatu/view/light";
import { bounds, groups, root } from "tatu/view/objects";
import { drawSimplified, isLargeForSoftware, isSoftware } from "tatu/view/software_rendering";

THREE.Object3D.DEFAULT_UP.set(0, 0, 1);
/** @import { SceneObject } from "tatu/protocol" */
/** @import { ObjectGroup } from "tatu/view/instancing" */

export const host = get("view");
/** Tangent of half the usual field of view. Parallel projection uses a narrower field of view at a greater distance. */
const USUAL_TANGENT = Math.tan((50 * Math.PI) / 360);
/** Width and height of the shadow map, pixels. */
const SHADOW_MAP_SIZE = 2048;

export const stage = new THREE.Scene();
export const camera = new THREE.PerspectiveCamera(50, 1, 0.02, 2000);
camera.up.set(0, 0, 1);
camera.position.set(3, -4, 2.5);
export const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
renderer.shadowMap.enabled = true;
// Checking for shader errors would block until each shader has been compiled.
renderer.debug.checkShaderErrors = false;
renderer.shadowMap.type = THREE.PCFShadowMap;
host.append(renderer.domElement);
export const controls = new OrbitControls(camera, renderer.domElement);
controls.target.set(0, 0, 0.2);

const sun = new THREE.DirectionalLight(0xffffff, 1);
sun.castShadow = true;
sun.shadow.mapSize.set(SHADOW_MAP_SIZE, SHADOW_MAP_SIZE);
sun.shadow.radius = 1.5;
stage.add(dome, floor, sun, sun.target, root, instancedGroup);
onThemeChange(redraw);

// Two directions perpendicular to the light. The shadow map is moved along them only by whole pixels; otherwise, the
// edges of shadows would flicker.
const across = new THREE.Vector3(0, 1, 0).cross(LAMP).normalize();
const along = LAMP.clone().cross(across);

/** Fits the shadow map to the part of the scene around the target of the camera. */
function fitShadowMap() {
  const reach = Math.min(Math.max(0.9 * zoom.value * camera.position.distanceTo(controls.target), 0.3), 60);
  const pixel = (2 * reach) / SHADOW_MAP_SIZE;
  const center = controls.target.clone();
  for (const axis of [across, along]) {
    const distance = center.dot(axis);
    center.addScaledVector(axis, Math.round(distance / pixel) * pixel - distance);
  }
  sun.target.position.copy(center);
  sun.position.copy(center).addScaledVector(LAMP, 4 * reach);
  Object.assign(sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.01, far: 8 * reach });
  sun.shadow.camera.updateProjectionMatrix();
  sun.shadow.normalBias = 1.2 * pixel;
}

/** Sets the near plane in proportion to the distance of the target. A closer near plane would reduce depth resolution. */
function setNearPlane() {
  const near = Math.max(0.005, 0.02 * camera.position.distanceTo(controls.target));
  if (Math.abs(near / camera.near - 1) < 0.1) return;
  Object.assign(camera, { near, far: 2000 / zoom.value });
  camera.updateProjectionMatrix();
}

/** Functions that are called before each rendering of the view. @type {Set<() => void>} */
const drawListeners = new Set();

/**
 * Calls `f` before each rendering of the view. Returns a function that ends this.
 * @param {() => void} f
 */
export function beforeDrawing(f) {
  drawListeners.add(f);
  return () => { drawListeners.delete(f); };
}

/**
 * Draws the image of another camera on a canvas. The image is rendered in a corner of the view, and the view must be
 * rendered again afterwards.
 * @param {THREE.PerspectiveCamera} other
 * @param {HTMLCanvasElement} canvas resized to its displayed size, at most to that of the view
 */
export function drawFromCamera(other, canvas) {
  const viewSize = renderer.getSize(new THREE.Vector2());
  const [w, h] = [Math.min(canvas.clientWidth, viewSize.x), Math.min(canvas.clientHeight, viewSize.y)];
  const ratio = renderer.getPixelRatio();
  const [columns, rows] = [Math.floor(w * ratio), Math.floor(h * ratio)];
  if (canvas.width !== columns || canvas.height !== rows) Object.assign(canvas, { width: columns, height: rows });
  updateInstances(other, rows);
  renderer.setScissorTest(true);
  renderer.setViewport(0, 0, w, h);
  renderer.setScissor(0, 0, w, h);
  renderer.render(stage, other);
  renderer.setScissorTest(false);
  renderer.setViewport(0, 0, viewSize.x, viewSize.y);
  const sourceRow = renderer.domElement.height - rows;
  canvas.getContext("2d")?.drawImage(renderer.domElement, 0, sourceRow, columns, rows, 0, 0, columns, rows);
}

const isSoftwareRendered = isSoftware(renderer);
/** With software rendering, images of large scenes are simplified if the last image is less than this time old, ms. */
const REST_TIME = 600;
/** Number of triangles of the last image, and the time at which it was drawn, ms. */
let [triangles, lastDrawn] = [0, -Infinity];
let restTimer = 0;
let isScheduled = false;
/** Number of times that the view has been rendered. */
export let drawn = 0;
/** Whether a scene has arrived. The view is not rendered before, because compiling the shaders takes 0.5 s. */
let hasScene = false;
watch("scene", () => { hasScene = true; });
/** Schedules a rendering of the view for the next animation frame. */
export function redraw() {
  if (isScheduled || !hasScene) return;
  isScheduled = true;
  requestAnimationFrame(() => {
    isScheduled = false;
    root.updateMatrixWorld();
    // Shadows are omitted in large scenes, because they would take too long.
    const isLargeScene = isLarge() || (isSoftwareRendered && isLargeForSoftware(triangles));
    sun.castShadow = !isLargeScene;
    zoom.value = Math.tan((camera.fov * Math.PI) / 360) / USUAL_TANGENT;
    setNearPlane();
    if (sun.castShadow) fitShadowMap();
    for (const f of drawListeners) f();
    updateInstances(camera, renderer.domElement.height);
    drawn++;
    clearTimeout(restTimer);
    if (isSoftwareRendered && isLargeScene && performance.now() - lastDrawn < REST_TIME) {
      triangles = drawSimplified(renderer, stage, camera);
      restTimer = setTimeout(redraw, REST_TIME);
    } else {
      renderer.render(stage, camera);
      ({ triangles } = renderer.info.render);
    }
    lastDrawn = performance.now();
  });
}
controls.addEventListener("change", redraw);
on("frame", (view) => { if (hasMotion(view)) redraw(); });

new ResizeObserver(() => {
  const { clientWidth: w, clientHeight: h } = host;
  if (!w || !h) return;
  renderer.setSize(w, h);
  camera.aspect = w / h;
  camera.updateProjectionMatrix();
  redraw();
}).observe(host);

/** Direction from the centre of the scene to the camera for a new scene. */
const DEFAULT_DIRECTION = new THREE.Vector3(-0.55, -0.65, 0.5).normalize();
/** Ratio of the size of the visible region to that of the objects. */
const MARGIN = 1.15;

/** Ratio of the size of the visible region of a new scene to that of its robots, and least ratio to that of the scene. */
const [ROBOT_MARGIN, SCENE_SHARE] = [1.6, 0.8];
/** Minimum radius of the visible region of a scene, m. */
const MIN_RADIUS = 0.7;

/** Returns the object without a parent that is above an object, or the object itself. @param {SceneObject} object */
function rootOf(object) {
  for (let o = object; ;) {
    const parent = scene.objects.get(o.parent);
    if (!parent) return o;
    o = parent;
  }
}

/** Returns the bounding box of the models that have joints: the robots of the scene, which will move. */
function robotBounds() {
  const all = [...scene.objects.values()];
  const robots = new Set(all.filter((o) => o.joint).map(rootOf).filter((o) => o.model));
  const box = new THREE.Box3();
  root.updateMatrixWorld(true);
  for (const o of all) if (robots.has(rootOf(o))) for (const mesh of groups.get(o.id)?.userData.bodies ?? []) box.expandByObject(mesh);
  return box;
}

/** Shows a new scene, nearer to its robots than to the rest. */
function fitScene() {
  const [robots, all] = [robotBounds(), bounds()];
  if (robots.isEmpty() || all.isEmpty()) return fit();
  const size = Math.max(ROBOT_MARGIN * robots.getSize(new THREE.Vector3()).length(), SCENE_SHARE * all.getSize(new THREE.Vector3()).length());
  fitSphere(robots.getCenter(new THREE.Vector3()).lerp(all.getCenter(new THREE.Vector3()), 0.5), Math.max(MIN_RADIUS, size / 2));
}

/**
 * Moves the camera so that the given objects, or all objects except floors, are visible.
 * @param {THREE.Object3D[]} [objects]
 * @param {THREE.Vector3} [direction] direction from the objects to the camera
 */
export function fit(objects, direction = DEFAULT_DIRECTION) {
  const box = objects ? new THREE.Box3() : bounds();
  for (const object of objects ?? []) box.expandByObject(object);
  if (box.isEmpty()) return;
  const center = box.getCenter(new THREE.Vector3());
  const size = box.getSize(new THREE.Vector3()).length();
  // The minimum radius keeps the camera from moving too close to a small scene, and even more so to an empty one.
  fitSphere(center, Math.max(objects ? 0.1 : size > 0 ? MIN_RADIUS : 2.5, size / 2), direction);
}

/**
 * Moves the camera so that a sphere is visible.
 * @param {THREE.Vector3} center
 * @param {number} radius m
 * @param {THREE.Vector3} [direction] direction from the sphere to the camera
 */
function fitSphere(center, radius, direction = DEFAULT_DIRECTION) {
  const upright = (camera.fov * Math.PI) / 360;
  const half = Math.min(upright, Math.atan(Math.tan(upright) * camera.aspect));
  camera.position.copy(center).addScaledVector(direction, (MARGIN * radius) / Math.sin(half));
  controls.target.copy(center);
  controls.update();
  redraw();
}

/**
 * Moves the camera to the pose of a scene camera. The target is on the z axis of that camera, at the distance of the
 * centre of the scene.
 * @param {ObjectGroup} group
 */
function moveCameraTo(group) {
  root.updateMatrixWorld(true);
  const box = bounds();
  const ahead = new THREE.Vector3(0, 0, 1).transformDirection(group.matrixWorld);
  const from = group.getWorldPosition(new THREE.Vector3());
  const center = box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3());
  const far = Math.max(0.5, center.clone().sub(from).dot(ahead));
  camera.position.copy(from);
  controls.target.copy(from).addScaledVector(ahead, far);
  controls.update();
  redraw();
}

/** Shows a floor below the lowest object if the scene does not have a visible plane. */
function updateFloor() {
  const all = [...scene.objects.values()];
  const hasFloor = all.some((o) => o.visible && o.parts?.some((p) => p.form === "plane"));
  const box = bounds();
  placeFloor((box.isEmpty() ? 0 : Math.min(0, box.min.z)) - 1e-4, !hasFloor);
}

watch("scene", () => {
  updateFloor();
  // A new scene is shown from its first camera, or completely if it has none. An update of the scene does not move the
  // camera.
  const sceneCamera = [...scene.objects.values()].find((o) => o.kind === "camera");
  if (scene.isNew) {
    requestAnimationFrame(() => {
      const group = groups.get(sceneCamera?.id ?? 0);
      if (group) moveCameraTo(group);
      else fitScene();
    });
  }
  redraw();
});

watch("objects", () => {
  updateFloor();
  redraw();
});
