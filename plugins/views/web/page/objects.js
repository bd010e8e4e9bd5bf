// Objects of the scene as groups of meshes, and where they stand.

import * as THREE from "three";
import { MANY, gather, hang, scatter } from "tatu/crowd";
import { on } from "tatu/net";
import { scene, selected, watch } from "tatu/store";

/** Everything of the scene. */
export const root = new THREE.Group();
/** The group of each object, by handle; what hangs on a joint hangs on `moved` of its group. */
export const groups = new Map();
const meshes = new Map();
const materials = new Map();
const PLANE = 40;
const UP = new THREE.Vector3(0, 0, 1);

on("mesh", (view) => {
  const bytes = new Uint8Array(view.buffer);
  const sum = new TextDecoder().decode(bytes.subarray(4, 20));
  if (meshes.has(sum)) return;
  const points = view.getUint32(20, true);
  const triangles = view.getUint32(24, true);
  const position = new Float32Array(view.buffer.slice(28, 28 + points * 12));
  const index = new Uint32Array(view.buffer.slice(28 + points * 12, 28 + points * 12 + triangles * 12));
  let geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  // Flat faces and sharp edges: what is drawn is what is there.
  geometry = geometry.toNonIndexed();
  geometry.computeVertexNormals();
  meshes.set(sum, geometry);
});

const shared = {
  box: new THREE.BoxGeometry(1, 1, 1),
  sphere: new THREE.SphereGeometry(0.5, 32, 16),
  cylinder: new THREE.CylinderGeometry(0.5, 0.5, 1, 32).rotateX(Math.PI / 2),
  plane: new THREE.PlaneGeometry(PLANE, PLANE),
};
/** What stands for round things in large scenes, where each is small. */
const coarse = new Map([
  [shared.sphere, new THREE.SphereGeometry(0.5, 10, 6)],
  [shared.cylinder, new THREE.CylinderGeometry(0.5, 0.5, 1, 10).rotateX(Math.PI / 2)],
]);

function material(color) {
  const key = color.map((x) => x.toFixed(3)).join();
  if (!materials.has(key)) {
    const linear = new THREE.Color().setRGB(...color, THREE.SRGBColorSpace);
    materials.set(key, new THREE.MeshLambertMaterial({ color: linear, side: THREE.DoubleSide }));
  }
  return materials.get(key);
}

function body(part) {
  if (part.form === "mesh") return new THREE.Mesh(meshes.get(part.mesh) ?? new THREE.BufferGeometry(), material(part.color));
  if (part.form === "capsule") {
    const [d, , l] = part.size;
    return new THREE.Mesh(new THREE.CapsuleGeometry(d / 2, Math.max(0, l - d), 8, 24).rotateX(Math.PI / 2), material(part.color));
  }
  const mesh = new THREE.Mesh(shared[part.form] ?? shared.box, material(part.color));
  if (part.size?.length) mesh.scale.set(...part.size);
  return mesh;
}

/** Places a thing by seven numbers. */
function place(thing, [x, y, z, a, b, c, d]) {
  thing.position.set(x, y, z);
  thing.quaternion.set(a, b, c, d);
}

function joint(group, o) {
  group.userData.joint = o.joint;
  const moved = new THREE.Group();
  group.add(moved);
  group.userData.moved = moved;
}

function path(group, o) {
  const points = [];
  for (let i = 0; i + 6 < (o.points?.length ?? 0); i += 7) points.push(new THREE.Vector3(o.points[i], o.points[i + 1], o.points[i + 2]));
  if (points.length < 2) return;
  if (o.closed) points.push(points[0]);
  group.add(new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({ color: 0x3b82f6 })));
}

const hidden = document.getElementById("hidden");
/** The layers of a scene that are seen at first, as in the original: the lower eight. */
const SEEN = 0xff;

function show() {
  for (const o of scene.objects.values()) {
    const is = o.visible && (hidden.checked || (o.layer & SEEN) !== 0);
    for (const mesh of groups.get(o.id)?.userData.bodies ?? []) mesh.visible = is;
  }
}
hidden.onchange = show;

watch("scene", () => {
  scatter(root);
  root.clear();
  groups.clear();
  let parts = 0;
  for (const o of scene.objects.values()) {
    const group = new THREE.Group();
    group.userData = { id: o.id, bodies: [] };
    place(group, o.pose);
    if (o.kind === "joint") joint(group, o);
    if (o.kind === "path") path(group, o);
    for (const part of o.parts ?? []) {
      const mesh = body(part);
      place(mesh, part.pose);
      mesh.userData.id = o.id;
      mesh.castShadow = part.form !== "plane";
      mesh.receiveShadow = true;
      group.userData.bodies.push(mesh);
      group.add(mesh);
      parts++;
    }
    groups.set(o.id, group);
  }
  for (const o of scene.objects.values()) {
    const above = groups.get(o.parent);
    (above ? (above.userData.moved ?? above) : root).add(groups.get(o.id));
  }
  show();
  if (parts > MANY) {
    for (const group of groups.values()) {
      for (const mesh of group.userData.bodies) mesh.geometry = coarse.get(mesh.geometry) ?? mesh.geometry;
    }
    gather(root, groups);
  }
});

/** Takes a turn as it is sent. */
function turn(quaternion, view, at) {
  quaternion.set(view.getInt16(at, true), view.getInt16(at + 2, true), view.getInt16(at + 4, true), view.getInt16(at + 6, true)).normalize();
}

function numbers(view, at, n) {
  return Array.from({ length: n }, (_, i) => view.getFloat64(at + 8 * i, true));
}

function move(group, x) {
  const { moved, joint: j } = group.userData;
  if (!moved) return;
  if (j.type === "prismatic") return moved.position.set(0, 0, x);
  moved.quaternion.setFromAxisAngle(UP, x);
  moved.position.set(0, 0, (j.lead * x) / (2 * Math.PI));
}

on("frame", (view) => {
  const count = view.getUint32(16, true);
  let at = 20;
  for (let i = 0; i < count; i++) {
    const head = view.getUint32(at, true);
    at += 4;
    const group = groups.get(head & 0xffffff);
    switch (head >>> 24) {
      case 0:
        if (group) {
          group.position.set(view.getInt32(at, true) / 1e4, view.getInt32(at + 4, true) / 1e4, view.getInt32(at + 8, true) / 1e4);
          turn(group.quaternion, view, at + 12);
        }
        at += 20;
        break;
      case 1:
        if (group) move(group, view.getFloat32(at, true));
        at += 4;
        break;
      case 2:
        if (group?.userData.moved) turn(group.userData.moved.quaternion, view, at);
        at += 8;
        break;
      // Those of a film, in full precision.
      case 3:
        if (group) place(group, numbers(view, at, 7));
        at += 56;
        break;
      case 4:
        if (group) move(group, view.getFloat64(at, true));
        at += 8;
        break;
      case 5:
        group?.userData.moved?.quaternion.set(...numbers(view, at, 4));
        at += 32;
        break;
      default:
        return;
    }
  }
});

/** The box around what is seen, without endless planes and what lies far off. */
export function bounds() {
  const box = new THREE.Box3();
  root.updateMatrixWorld(true);
  for (const group of groups.values()) {
    for (const mesh of group.userData.bodies) {
      if (!mesh.visible || mesh.geometry === shared.plane) continue;
      mesh.geometry.boundingBox ?? mesh.geometry.computeBoundingBox();
      mesh.updateMatrix();
      const matrix = new THREE.Matrix4().multiplyMatrices(group.matrixWorld, mesh.matrix);
      const own = mesh.geometry.boundingBox.clone().applyMatrix4(matrix);
      if (!own.isEmpty() && own.min.length() < 1e3 && own.max.length() < 1e3) box.union(own);
    }
  }
  // Without shapes there are places.
  if (box.isEmpty()) for (const group of groups.values()) box.expandByPoint(group.getWorldPosition(new THREE.Vector3()));
  return box;
}

// What is selected has a border of its own.
let border = null;
watch("selected", () => {
  border?.removeFromParent();
  border = null;
  const group = groups.get(selected());
  if (!group) return;
  border = new THREE.Group();
  for (const mesh of group.userData.bodies) {
    const edges = new THREE.LineSegments(new THREE.EdgesGeometry(mesh.geometry, 25), new THREE.LineBasicMaterial({ color: 0xffa500 }));
    edges.position.copy(mesh.position);
    edges.quaternion.copy(mesh.quaternion);
    edges.scale.copy(mesh.scale);
    border.add(edges);
  }
  if (!group.userData.bodies.length) border.add(new THREE.AxesHelper(0.2));
  hang(group, border);
});
