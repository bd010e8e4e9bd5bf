// @ts-check
// Represents each object of the scene by a group of meshes, and updates its pose.

import * as THREE from "three";
import { get } from "tatu/lib/dom";
import { eachEntry, parseMesh } from "tatu/net/binary_messages";
import { on } from "tatu/net/connection";
import { subtree } from "tatu/scene/hierarchy";
import { scene, selection, watch } from "tatu/scene/store";
import { LARGE_SCENE_PARTS, attachTo, disableInstancing, enableInstancing, isLarge } from "tatu/view/instancing";
import { infinitePlane, opacityParameters, sceneMaterial } from "tatu/view/light";
import { applyTexture } from "tatu/view/textures";

/** @import { Joint, VisiblePart, SceneObject } from "tatu/protocol" */
/** @import { Body, ObjectGroup } from "tatu/view/instancing" */

/** The group that contains the groups of all objects. */
export const root = new THREE.Group();
/**
 * The groups of all objects, by handle. Children of a joint are attached to `moved` of its group.
 * @type {Map<number, ObjectGroup>}
 */
export const groups = new Map();
/** The received meshes, by hash. @type {Map<string, THREE.BufferGeometry>} */
const meshes = new Map();
/** The materials, by color and opacity. @type {Map<string, THREE.MeshLambertMaterial>} */
const materials = new Map();
const UP = new THREE.Vector3(0, 0, 1);

on("mesh", (view) => {
  const { hash, points, triangles, coordinates } = parseMesh(view);
  if (meshes.has(hash)) return;
  let geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
  if (coordinates) geometry.setAttribute("uv", new THREE.BufferAttribute(coordinates, 2));
  geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
  // Flat shading shows the actual faces of the mesh.
  geometry = geometry.toNonIndexed();
  geometry.computeVertexNormals();
  meshes.set(hash, geometry);
});

/** @type {{ [form: string]: THREE.BufferGeometry }} */
const SHAPES = {
  box: new THREE.BoxGeometry(1, 1, 1),
  sphere: new THREE.SphereGeometry(0.5, 32, 16),
  cylinder: new THREE.CylinderGeometry(0.5, 0.5, 1, 32).rotateX(Math.PI / 2),
  plane: infinitePlane(),
};
/** Coarser geometries that replace those of round forms in large scenes, in which each part is small. */
const coarse = new Map([
  [SHAPES.sphere, /** @type {THREE.BufferGeometry} */ (new THREE.SphereGeometry(0.5, 10, 6))],
  [SHAPES.cylinder, new THREE.CylinderGeometry(0.5, 0.5, 1, 10).rotateX(Math.PI / 2)],
]);

/**
 * Returns the material of a part, which is shared by parts of the same color and opacity.
 * @param {VisiblePart} part
 */
function material({ color, opacity = 1, form }) {
  const closed = form !== "mesh" && form !== "plane";
  const key = [...color, opacity].map((x) => x.toFixed(3)).join() + (opacity < 1 && closed);
  let found = materials.get(key);
  if (!found) {
    const linear = new THREE.Color().setRGB(...color, THREE.SRGBColorSpace);
    found = sceneMaterial({ color: linear, ...opacityParameters(opacity, closed) });
    materials.set(key, found);
  }
  return found;
}

/**
 * Creates the mesh of a part.
 * @param {VisiblePart} part
 * @returns {Body}
 */
function partMesh(part) {
  const mesh = untexturedMesh(part);
  const textured = part.texture && applyTexture(part.texture, part, mesh.geometry, mesh.scale);
  if (textured) [mesh.geometry, mesh.material] = [textured.geometry, textured.material];
  return mesh;
}

/**
 * Creates the mesh of a part, without its texture.
 * @param {VisiblePart} part
 * @returns {Body}
 */
function untexturedMesh(part) {
  if (part.form === "mesh") return new THREE.Mesh(meshes.get(part.mesh ?? "") ?? new THREE.BufferGeometry(), material(part));
  if (part.form === "capsule") {
    const [d = 1, , l = 1] = part.size ?? [];
    return new THREE.Mesh(new THREE.CapsuleGeometry(d / 2, Math.max(0, l - d), 8, 24).rotateX(Math.PI / 2), material(part));
  }
  const mesh = new THREE.Mesh(SHAPES[part.form] ?? SHAPES.box, material(part));
  if (part.size?.length === 3) mesh.scale.fromArray(part.size);
  return mesh;
}

/**
 * Sets the position and quaternion of a three.js object.
 * @param {THREE.Object3D} thing
 * @param {number[]} pose
 */
function setPose(thing, pose) {
  thing.position.fromArray(pose);
  thing.quaternion.fromArray(pose, 3);
}

/**
 * Sets the description of a joint, and creates the group that the joint moves.
 * @param {ObjectGroup} group
 * @param {Joint} description
 */
function setJoint(group, description) {
  group.userData.joint = description;
  if (group.userData.moved) return;
  const moved = new THREE.Group();
  group.add(moved);
  group.userData.moved = moved;
}

/**
 * Draws the line of a path.
 * @param {ObjectGroup} group
 * @param {SceneObject} o
 */
function addPath(group, o) {
  const points = [];
  const numbers = o.points ?? [];
  for (let i = 0; i + 6 < numbers.length; i += 7) points.push(new THREE.Vector3().fromArray(numbers, i));
  const [first] = points;
  if (points.length < 2 || !first) return;
  if (o.closed) points.push(first);
  addRepresentation(group, new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({ color: 0x3b82f6 })));
}

const hiddenLayers = get("hidden", HTMLInputElement);
/** Bit mask of the layers that are visible by default: the lower eight, as in V-REP. */
const DEFAULT_LAYERS = 0xff;

/**
 * Shows or hides the parts of all objects according to their visibility, layers, and the check box for hidden layers.
 */
function updateVisibility() {
  for (const o of scene.objects.values()) {
    const isVisible = o.visible && (hiddenLayers.checked || (o.layer & DEFAULT_LAYERS) !== 0);
    for (const mesh of groups.get(o.id)?.userData.bodies ?? []) mesh.visible = isVisible;
  }
}
hiddenLayers.onchange = updateVisibility;

/**
 * Builds the parts of an object in its group again. Objects attached to the group are not affected.
 * @param {ObjectGroup} group
 * @param {SceneObject} o
 */
function buildParts(group, o) {
  for (const old of group.userData.representation) old.removeFromParent();
  group.userData.representation = [];
  group.userData.bodies = [];
  setPose(group, o.pose);
  if (o.joint) setJoint(group, o.joint);
  if (o.kind === "path") addPath(group, o);
  for (const part of o.parts ?? []) {
    const mesh = partMesh(part);
    setPose(mesh, part.pose);
    mesh.userData.id = o.id;
    mesh.castShadow = part.form !== "plane" && (part.opacity ?? 1) >= 1;
    mesh.receiveShadow = true;
    group.userData.bodies.push(mesh);
    addRepresentation(group, mesh);
  }
}

/**
 * Adds a three.js object that represents an object of the scene, and is removed when that object is built again.
 * @param {ObjectGroup} group
 * @param {THREE.Object3D} thing
 */
function addRepresentation(group, thing) {
  group.userData.representation.push(thing);
  group.add(thing);
}

/** @param {number} id */
function newGroup(id) {
  const group = /** @type {ObjectGroup} */ (new THREE.Group());
  group.userData = { id, bodies: [], representation: [] };
  return group;
}

/**
 * Returns the group to which the group of an object is attached.
 * @param {SceneObject} o
 */
function parentGroup(o) {
  const found = groups.get(o.parent);
  return found ? (found.userData.moved ?? found) : root;
}

/** Attaches the groups of all objects to those of their parents. */
function attach() {
  for (const o of scene.objects.values()) {
    const group = groups.get(o.id);
    if (group && group.parent !== parentGroup(o)) parentGroup(o).add(group);
  }
}

/** Switches instancing on if the scene is large. */
function instanceIfLarge() {
  let parts = 0;
  for (const group of groups.values()) parts += group.userData.bodies.length;
  if (parts <= LARGE_SCENE_PARTS) return;
  for (const group of groups.values()) {
    for (const mesh of group.userData.bodies) mesh.geometry = coarse.get(mesh.geometry) ?? mesh.geometry;
  }
  enableInstancing(root, groups);
}

watch("scene", () => {
  disableInstancing(root);
  root.clear();
  groups.clear();
  for (const o of scene.objects.values()) {
    const group = newGroup(o.id);
    buildParts(group, o);
    groups.set(o.id, group);
  }
  attach();
  updateVisibility();
  instanceIfLarge();
  outlineSelection();
});

watch("objects", (changed) => {
  // With instancing, bodies are not attached to their groups, so it is switched off during the change.
  const large = isLarge();
  if (large) {
    disableInstancing(root);
    for (const group of groups.values()) group.add(...group.userData.bodies);
  }
  for (const o of changed) {
    const group = groups.get(o.id);
    if (group) buildParts(group, o);
  }
  attach();
  updateVisibility();
  if (large) instanceIfLarge();
  outlineSelection();
});

/**
 * Sets the position of a joint.
 * @param {ObjectGroup} group
 * @param {number} x rad or m
 */
function moveJoint(group, x) {
  const { moved, joint: j } = group.userData;
  if (!moved || !j) return;
  if (j.type === "prismatic") {
    moved.position.set(0, 0, x);
    return;
  }
  moved.quaternion.setFromAxisAngle(UP, x);
  moved.position.set(0, 0, (j.lead * x) / (2 * Math.PI));
}

on("frame", (view) => {
  eachEntry(view, (id, what, numbers) => {
    const group = groups.get(id);
    if (!group) return;
    if (what === "pose") {
      setPose(group, numbers);
      group.quaternion.normalize();
    } else if (what === "position") moveJoint(group, numbers[0] ?? 0);
    else group.userData.moved?.quaternion.fromArray(numbers).normalize();
  });
});

/**
 * Returns the size of the bounding box of an object's parts in the frame of the object, m; null if it has no parts or is
 * an infinite plane.
 * @param {number} id
 */
export function sizeOf(id) {
  const box = new THREE.Box3();
  for (const mesh of groups.get(id)?.userData.bodies ?? []) {
    if (mesh.geometry === SHAPES.plane) return null;
    mesh.geometry.boundingBox ?? mesh.geometry.computeBoundingBox();
    mesh.updateMatrix();
    box.union((mesh.geometry.boundingBox ?? new THREE.Box3()).clone().applyMatrix4(mesh.matrix));
  }
  return box.isEmpty() ? null : box.getSize(new THREE.Vector3()).toArray();
}

/** Returns the bounding box of visible objects, except infinite planes and objects farther than 1 km from the origin. */
export function bounds() {
  const box = new THREE.Box3();
  root.updateMatrixWorld(true);
  for (const group of groups.values()) {
    for (const mesh of group.userData.bodies) {
      if (!mesh.visible || mesh.geometry === SHAPES.plane) continue;
      mesh.geometry.boundingBox ?? mesh.geometry.computeBoundingBox();
      mesh.updateMatrix();
      const matrix = new THREE.Matrix4().multiplyMatrices(group.matrixWorld, mesh.matrix);
      const partBox = (mesh.geometry.boundingBox ?? new THREE.Box3()).clone().applyMatrix4(matrix);
      if (!partBox.isEmpty() && partBox.min.length() < 1e3 && partBox.max.length() < 1e3) box.union(partBox);
    }
  }
  // If no shape is visible, the box contains the positions of all objects instead.
  if (box.isEmpty()) for (const group of groups.values()) box.expandByPoint(group.getWorldPosition(new THREE.Vector3()));
  return box;
}

/** The outlines of the selected objects. @type {THREE.Group[]} */
let selectionOutlines = [];
/** @type {WeakMap<THREE.BufferGeometry, THREE.EdgesGeometry>} */
const outlines = new WeakMap();
const OUTLINE_MATERIAL = new THREE.LineBasicMaterial({ color: 0xffa500 });

/**
 * Returns the edges of a geometry, which are computed only once.
 * @param {THREE.BufferGeometry} geometry
 */
export function edgesOf(geometry) {
  const existing = outlines.get(geometry);
  if (existing) return existing;
  const edges = new THREE.EdgesGeometry(geometry, 25);
  outlines.set(geometry, edges);
  return edges;
}

/**
 * Returns the groups to be outlined for an object: its own group, and for a model those of all objects below it.
 * @param {number} id
 */
function outlinedGroups(id) {
  const ids = scene.objects.get(id)?.model ? subtree(id) : [id];
  return ids.flatMap((one) => groups.get(one) ?? []);
}

/** Outlines the selected objects. */
function outlineSelection() {
  for (const old of selectionOutlines) old.removeFromParent();
  selectionOutlines = selection().flatMap((id) => outlinedGroups(id).map((group) => {
    const outline = new THREE.Group();
    for (const mesh of group.userData.bodies) {
      if (!mesh.visible) continue;
      const edges = new THREE.LineSegments(edgesOf(mesh.geometry), OUTLINE_MATERIAL);
      edges.position.copy(mesh.position);
      edges.quaternion.copy(mesh.quaternion);
      edges.scale.copy(mesh.scale);
      outline.add(edges);
    }
    if (group.userData.id === id && !group.userData.bodies.length) outline.add(new THREE.AxesHelper(0.2));
    attachTo(group, outline);
    return outline;
  }));
}
watch("selected", outlineSelection);
