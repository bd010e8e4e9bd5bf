// @ts-check
// Large scenes: equal parts are drawn by instancing. Distant parts are drawn as boxes, and parts that are too small to
// be visible are omitted.

import * as THREE from "three";
import { sceneMaterial } from "tatu/view/light";

/** @import { Joint } from "tatu/protocol" */

/** @typedef {THREE.Mesh<THREE.BufferGeometry, THREE.MeshLambertMaterial>} Body */
/**
 * The group of an object. `bodies` are the meshes of its parts, `representation` all three.js objects that represent
 * the object itself, and `moved` the group that a joint moves.
 * @typedef {THREE.Group & { userData: { id: number, bodies: Body[], representation: THREE.Object3D[], joint?: Joint, moved?: THREE.Group } }} ObjectGroup
 */
/** @typedef {{ group: ObjectGroup, body: Body }} PlacedBody */
/** @typedef {PlacedBody & { radius: number, center: THREE.Vector3, asBox: THREE.Matrix4 }} DrawnPart */
/** @typedef {THREE.InstancedMesh<THREE.BufferGeometry, THREE.MeshLambertMaterial>} Instances */

/** Number of parts above which a scene is large, so that instancing is used. */
export const LARGE_SCENE_PARTS = 1500;
/** Size on the screen, pixels, below which a part is drawn as a box. */
const BOX_SIZE = 14;
/** Size on the screen, pixels, below which a part is not drawn. */
const SMALLEST_SIZE = 2.5;

/**
 * The instanced meshes, and the three.js objects that are attached to groups, such as outlines. Used only while
 * instancing is switched on; the renderer then skips the groups of the objects.
 */
export const instancedGroup = new THREE.Group();
/** @type {{ group: THREE.Object3D, attached: THREE.Object3D }[]} */
let attachments = [];
/**
 * The parts by geometry and material, with the instanced meshes that draw them exactly (`near`) and as boxes (`far`).
 * @type {{ parts: DrawnPart[], near: Instances, far: Instances }[]}
 */
let batches = [];
/** A box with 8 vertices instead of 24, which speeds up software rendering. */
const box = new THREE.BufferGeometry();
box.setAttribute("position", new THREE.Float32BufferAttribute([0, 1, 2, 3, 4, 5, 6, 7].flatMap((i) => [(i & 1) - 0.5, ((i >> 1) & 1) - 0.5, (i >> 2) - 0.5]), 3));
box.setIndex([0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5]);
const [product, frustum, sphere] = [new THREE.Matrix4(), new THREE.Frustum(), new THREE.Sphere()];

/**
 * Returns a single-sided material of the same color for boxes, because the inside of a box is never visible.
 * @param {THREE.MeshLambertMaterial} material
 */
function boxMaterial(material) {
  const { color, transparent, opacity, depthWrite } = material;
  return sceneMaterial({ color, transparent, opacity, depthWrite, flatShading: true }, true);
}

/**
 * Adds a mesh for up to `n` instances.
 * @param {THREE.BufferGeometry} geometry
 * @param {THREE.MeshLambertMaterial} material
 * @param {number} n
 */
function addInstances(geometry, material, n) {
  const mesh = new THREE.InstancedMesh(geometry, material, n);
  mesh.frustumCulled = false;
  mesh.userData.ids = [];
  instancedGroup.add(mesh);
  return mesh;
}

/**
 * Switches to instancing for all bodies of these groups.
 * @param {THREE.Object3D} root
 * @param {Map<number, ObjectGroup>} groups
 */
export function enableInstancing(root, groups) {
  /** @type {Map<string, PlacedBody[]>} */
  const placedByKey = new Map();
  for (const group of groups.values()) {
    for (const body of group.userData.bodies) {
      body.updateMatrix();
      body.removeFromParent();
      const key = `${body.geometry.uuid} ${body.material.uuid}`;
      const existing = placedByKey.get(key);
      if (existing) existing.push({ group, body });
      else placedByKey.set(key, [{ group, body }]);
    }
  }
  root.visible = root.matrixWorldAutoUpdate = false;
  batches = [...placedByKey.values()].flatMap((placed) => {
    const [first] = placed;
    if (!first) return [];
    const { geometry, material } = first.body;
    geometry.boundingBox ?? geometry.computeBoundingBox();
    const bounds = geometry.boundingBox ?? new THREE.Box3();
    const size = bounds.getSize(new THREE.Vector3());
    const center = bounds.getCenter(new THREE.Vector3());
    const parts = placed.map(({ group, body }) => ({
      group,
      body,
      radius: 0.5 * size.clone().multiply(body.scale).length(),
      center: center.clone().applyMatrix4(body.matrix),
      asBox: body.matrix.clone().multiply(new THREE.Matrix4().makeTranslation(center)).scale(size.clone().max(new THREE.Vector3(1e-4, 1e-4, 1e-4))),
    }));
    return [{ parts, near: addInstances(geometry, material, parts.length), far: addInstances(box, boxMaterial(material), parts.length) }];
  });
}

/** Returns whether instancing is used. */
export function isLarge() {
  return batches.length > 0;
}

/**
 * Attaches a three.js object, such as an outline, to the group of an object, with or without instancing.
 * @param {THREE.Object3D} group
 * @param {THREE.Object3D} attached
 */
export function attachTo(group, attached) {
  if (!isLarge()) {
    group.add(attached);
    return;
  }
  attached.matrixAutoUpdate = false;
  instancedGroup.add(attached);
  attachments.push({ group, attached });
}

/**
 * Switches instancing off.
 * @param {THREE.Object3D} root
 */
export function disableInstancing(root) {
  root.visible = root.matrixWorldAutoUpdate = true;
  for (const { attached } of attachments) attached.removeFromParent();
  attachments = [];
  for (const { near, far } of batches) {
    for (const mesh of [near, far]) {
      mesh.removeFromParent();
      mesh.dispose();
    }
    far.material.dispose();
  }
  batches = [];
}

/**
 * Appends an instance of the object `id` with the matrix in `product`.
 * @param {Instances} mesh
 * @param {number} id
 */
function appendInstance(mesh, id) {
  product.toArray(mesh.instanceMatrix.array, 16 * mesh.count);
  mesh.userData.ids[mesh.count++] = id;
}

/**
 * Updates the instances of all parts for an image of a camera.
 * @param {THREE.PerspectiveCamera} camera
 * @param {number} height of the image, pixels
 */
export function updateInstances(camera, height) {
  if (!batches.length) return;
  camera.updateMatrixWorld();
  frustum.setFromProjectionMatrix(product.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
  const pixels = height / Math.tan((camera.fov * Math.PI) / 360);
  const eye = camera.position;
  attachments = attachments.filter(({ attached }) => attached.parent);
  for (const { group, attached } of attachments) attached.matrix.copy(group.matrixWorld);
  for (const { parts, near, far } of batches) {
    near.count = far.count = 0;
    for (const { group, body, radius, center, asBox } of parts) {
      if (!body.visible) continue;
      sphere.center.copy(center).applyMatrix4(group.matrixWorld);
      sphere.radius = radius;
      const across = (pixels * radius) / Math.max(1e-3, sphere.center.distanceTo(eye));
      if (across < SMALLEST_SIZE || !frustum.intersectsSphere(sphere)) continue;
      product.multiplyMatrices(group.matrixWorld, across < BOX_SIZE ? asBox : body.matrix);
      appendInstance(across < BOX_SIZE ? far : near, group.userData.id);
    }
    for (const mesh of [near, far]) {
      mesh.instanceMatrix.needsUpdate = true;
      // The next raycast computes the bounding sphere again.
      mesh.boundingSphere = null;
    }
  }
}

/**
 * Returns the handle of the object that a ray has hit, or 0 if it is not part of the scene.
 * @param {THREE.Intersection} hit
 * @returns {number}
 */
export function hitId({ object, instanceId }) {
  return object.userData.ids?.[instanceId ?? -1] ?? object.userData.id ?? 0;
}
