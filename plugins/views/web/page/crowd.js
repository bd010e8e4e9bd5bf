// Large scenes: parts that look alike are drawn together. Each part has a place in one of few instanced meshes.

import * as THREE from "three";

/** With more parts than this, parts are drawn together. */
export const MANY = 1500;

const NOWHERE = new THREE.Matrix4().makeScale(0, 0, 0);
const product = new THREE.Matrix4();
let entries = [];
let meshes = [];

/** Takes the bodies of all groups out of the tree and draws them together, below `root`. */
export function gather(root, groups) {
  entries = [];
  meshes = [];
  const alike = new Map();
  for (const group of groups.values()) {
    for (const body of group.userData.bodies) {
      body.updateMatrix();
      body.removeFromParent();
      const key = `${body.geometry.uuid} ${body.material.uuid}`;
      if (!alike.has(key)) alike.set(key, []);
      alike.get(key).push({ group, body });
    }
  }
  for (const all of alike.values()) {
    const [{ body }] = all;
    const mesh = new THREE.InstancedMesh(body.geometry, body.material, all.length);
    mesh.frustumCulled = false;
    mesh.userData.ids = all.map((e) => e.group.userData.id);
    all.forEach((e, i) => entries.push({ ...e, mesh, i }));
    meshes.push(mesh);
    root.add(mesh);
  }
}

/** Whether parts are drawn together. */
export function isLarge() {
  return meshes.length > 0;
}

/** Nothing is drawn together any more. */
export function scatter() {
  for (const mesh of meshes) mesh.removeFromParent();
  [entries, meshes] = [[], []];
}

/** Puts all parts where their objects stand. */
export function place() {
  for (const { group, body, mesh, i } of entries) {
    mesh.setMatrixAt(i, body.visible ? product.multiplyMatrices(group.matrixWorld, body.matrix) : NOWHERE);
  }
  for (const mesh of meshes) mesh.instanceMatrix.needsUpdate = true;
}

/** The object that a hit of a ray means; 0: none. */
export function hitId({ object, instanceId }) {
  return object.userData.ids?.[instanceId] ?? object.userData.id ?? 0;
}
