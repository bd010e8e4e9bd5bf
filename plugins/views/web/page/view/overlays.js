// @ts-check
// Overlays that are drawn over the scene: contacts with their forces, centres of mass, inertias, velocities, colliding
// shapes, axes and limits of joints, frames, and the manipulability of arms.

import * as THREE from "three";
import { get, make } from "tatu/lib/dom";
import { principal } from "tatu/lib/inertia";
import { t } from "tatu/lib/language";
import { hasMotion } from "tatu/net/binary_messages";
import { on, send } from "tatu/net/connection";
import { scene, selected, selection, watch } from "tatu/scene/store";
import { edgesOf, groups } from "tatu/view/objects";
import { ellipsoidSegments, requestEllipsoid } from "tatu/view/manipulability";
import { camera, controls, redraw, stage } from "tatu/view/renderer";

/** @import { BodyMark, ContactMark, Joint } from "tatu/protocol" */

const KINDS = /** @type {const} */ ({
  contacts: t`Contacts and forces`,
  masses: t`Centres of mass`,
  inertia: t`Inertia, as boxes of equal mass`,
  colliders: t`Shapes that collide`,
  velocities: t`Velocities`,
  joints: t`Axes of joints and their limits`,
  frames: t`Frames of the selection`,
  manipulability: t`Manipulability of the selection`,
});
/** @typedef {keyof typeof KINDS} Kind */

const KEY = "tatu overlays";
/** The enabled overlays. @type {Set<string>} */
const enabled = new Set((localStorage.getItem(KEY) ?? "").split(" ").filter((kind) => kind in KINDS));
const isEnabled = (/** @type {Kind} */ kind) => enabled.has(kind);

const overlayGroup = new THREE.Group();
overlayGroup.renderOrder = 2;
stage.add(overlayGroup);
const line = (/** @type {number} */ color) => new THREE.LineBasicMaterial({ color, depthTest: false, transparent: true });
const FORCE = line(0xe0352b);
const SPEED = line(0x2b7de0);
const AXIS = line(0xb35900);
const INERTIA = line(0x8a3ffc);
const COLLIDES = line(0x0d8a6a);
const MANIPULABILITY = line(0xc2185b);
const POINT = new THREE.PointsMaterial({ color: 0xe0352b, size: 6, sizeAttenuation: false, depthTest: false, transparent: true });
const MASS = new THREE.MeshBasicMaterial({ color: 0xf2c500, depthTest: false, transparent: true, opacity: 0.9 });
const BALL = new THREE.SphereGeometry(1, 12, 8);
const BOX = new THREE.EdgesGeometry(new THREE.BoxGeometry(1, 1, 1));
const UP = new THREE.Vector3(0, 0, 1);
const needsBodies = () => isEnabled("masses") || isEnabled("velocities") || isEnabled("inertia");

/** @type {ContactMark[]} */
let contacts = [];
/** @type {BodyMark[]} */
let bodies = [];

/**
 * Appends an arrow as line segments: a shaft and two strokes at its tip, perpendicular to the view.
 * @param {THREE.Vector3[]} out
 * @param {THREE.Vector3} from
 * @param {THREE.Vector3} vector
 */
function arrow(out, from, vector) {
  const length = vector.length();
  if (length < 1e-6) return;
  const to = from.clone().add(vector);
  const side = vector.clone().cross(camera.position.clone().sub(from)).setLength(0.12 * length);
  const back = to.clone().addScaledVector(vector, -0.22);
  out.push(from, to, to, back.clone().add(side), to, back.sub(side));
}

/**
 * Draws line segments.
 * @param {THREE.Vector3[]} ends the two ends of each segment
 * @param {THREE.LineBasicMaterial} material
 */
function segments(ends, material) {
  if (ends.length) overlayGroup.add(new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(ends), material));
}

/**
 * Returns the ends of line segments, in the world frame, that show the range of a joint: an arc with spokes at its
 * ends, or a line with strokes across its ends.
 * @param {THREE.Object3D} group
 * @param {Joint} joint
 * @param {number} size radius of the arc, m
 */
function range(group, joint, size) {
  const [low, high] = joint.limits ?? [0, 0];
  /** @type {THREE.Vector3[]} */
  const ends = [];
  if (joint.type === "prismatic") {
    const across = new THREE.Vector3(0.4 * size, 0, 0);
    const [from, to] = [new THREE.Vector3(0, 0, low), new THREE.Vector3(0, 0, high)];
    ends.push(from, to);
    for (const end of [from, to]) ends.push(end.clone().add(across), end.clone().sub(across));
  } else if (joint.type === "revolute") {
    const n = Math.max(2, Math.ceil((high - low) / 0.15));
    const at = Array.from({ length: n + 1 }, (_, i) => low + ((high - low) * i) / n).map((a) => new THREE.Vector3(size * Math.cos(a), size * Math.sin(a), 0));
    for (let i = 0; i < n; i++) ends.push(/** @type {THREE.Vector3} */ (at[i]).clone(), /** @type {THREE.Vector3} */ (at[i + 1]).clone());
    for (const end of [at[0], at[n]]) if (end) ends.push(new THREE.Vector3(), end.clone());
  }
  return ends.map((p) => group.localToWorld(p));
}

/**
 * Returns the edges of the box of uniform density with the mass and inertia of a body.
 * @param {THREE.Object3D} group
 * @param {THREE.Vector3} center
 * @param {BodyMark} body
 */
function inertiaBox(group, center, body) {
  const { moments, axes } = principal(body.inertia);
  const total = moments[0] + moments[1] + moments[2];
  const size = moments.map((m) => Math.sqrt(Math.max(0, (6 * (total - 2 * m)) / body.mass)));
  const box = new THREE.LineSegments(BOX, INERTIA);
  box.userData.shared = true;
  box.position.copy(center);
  const [x, y, z] = axes.map((a) => new THREE.Vector3(...a));
  const turned = new THREE.Quaternion().setFromRotationMatrix(new THREE.Matrix4().makeBasis(x ?? UP, y ?? UP, z ?? UP));
  box.quaternion.copy(group.getWorldQuaternion(new THREE.Quaternion())).multiply(turned);
  box.scale.set(size[0] ?? 0, size[1] ?? 0, size[2] ?? 0);
  return box;
}

/** Redraws all enabled overlays. Sizes are relative to half the height of the view at the target of the camera. */
function draw() {
  for (const child of overlayGroup.children) {
    if (!child.userData.shared && (child instanceof THREE.LineSegments || child instanceof THREE.Points)) child.geometry.dispose();
  }
  overlayGroup.clear();
  const view = camera.position.distanceTo(controls.target) * Math.tan((camera.fov * Math.PI) / 360);
  if (isEnabled("contacts") && contacts.length) {
    const points = contacts.map((c) => new THREE.Vector3(...c.point));
    overlayGroup.add(new THREE.Points(new THREE.BufferGeometry().setFromPoints(points), POINT));
    // The arrow of the largest force has a length of 0.35 `view`, or less if the force is below 1 N.
    const maxForce = Math.max(1, ...contacts.map((c) => Math.hypot(...c.force)));
    /** @type {THREE.Vector3[]} */
    const ends = [];
    contacts.forEach((c, i) => { const at = points[i]; if (at) arrow(ends, at, new THREE.Vector3(...c.force).multiplyScalar((0.35 * view) / maxForce)); });
    segments(ends, FORCE);
  }
  /** @type {THREE.Vector3[]} */
  const speeds = [];
  for (const b of bodies) {
    const group = groups.get(b.id);
    if (!group || !needsBodies()) continue;
    const center = group.localToWorld(new THREE.Vector3(...b.com));
    if (isEnabled("inertia") && b.mass > 0) overlayGroup.add(inertiaBox(group, center, b));
    if (isEnabled("masses") && b.mass > 0) {
      const ball = new THREE.Mesh(BALL, MASS);
      ball.position.copy(center);
      ball.scale.setScalar(Math.min(0.03 * view, 0.012 * Math.cbrt(b.mass) + 0.006 * view));
      overlayGroup.add(ball);
    }
    // The arrow is as long as the displacement in one second, but at most a quarter of the height of the view.
    if (isEnabled("velocities")) arrow(speeds, center, new THREE.Vector3(...b.velocity).clampLength(0, 0.5 * view));
  }
  segments(speeds, SPEED);
  if (isEnabled("joints")) {
    /** @type {THREE.Vector3[]} */
    const ends = [];
    for (const o of scene.objects.values()) {
      const group = o.kind === "joint" ? groups.get(o.id) : null;
      if (!group) continue;
      ends.push(...[-1, 1].map((side) => group.localToWorld(new THREE.Vector3(0, 0, 0.06 * view * side))));
      if (o.joint?.limits) ends.push(...range(group, o.joint, 0.05 * view));
    }
    segments(ends, AXIS);
  }
  if (isEnabled("colliders")) {
    for (const o of scene.objects.values()) {
      const group = o.collides ? groups.get(o.id) : null;
      if (!group) continue;
      for (const [i, body] of group.userData.bodies.entries()) {
        // Infinite planes have no edges.
        if (o.parts?.[i]?.form === "plane") continue;
        const edges = new THREE.LineSegments(edgesOf(body.geometry), COLLIDES);
        edges.userData.shared = true;
        body.updateMatrix();
        edges.matrixAutoUpdate = false;
        edges.matrix.multiplyMatrices(group.matrixWorld, body.matrix);
        overlayGroup.add(edges);
      }
    }
  }
  // The largest radius is as long as a third of half the height of the view.
  if (isEnabled("manipulability")) segments(ellipsoidSegments(view / 3), MANIPULABILITY);
  if (isEnabled("frames")) {
    for (const id of selection()) {
      const group = groups.get(id);
      if (!group) continue;
      const axes = new THREE.AxesHelper(0.15 * view);
      for (const material of [axes.material].flat()) Object.assign(material, { depthTest: false, transparent: true });
      group.updateWorldMatrix(true, false);
      group.matrixWorld.decompose(axes.position, axes.quaternion, axes.scale);
      axes.scale.set(1, 1, 1);
      overlayGroup.add(axes);
    }
  }
  redraw();
}

/** Interval at which the manipulability is requested, ms. */
const MANIPULABILITY_INTERVAL = 100;
setInterval(() => {
  if (isEnabled("manipulability") && !document.hidden) requestEllipsoid(selected(), draw);
}, MANIPULABILITY_INTERVAL);

/** Requests the data of the enabled overlays, and redraws them. */
function requestData() {
  send({ type: "overlays", contacts: isEnabled("contacts"), bodies: needsBodies() });
  if (!isEnabled("contacts")) contacts = [];
  if (!needsBodies()) bodies = [];
  draw();
}

on("overlays", (message) => {
  ({ contacts, bodies } = message);
  draw();
});
on("hello", () => { if (enabled.size) requestData(); });
on("frame", (view) => { if (hasMotion(view) && enabled.size && (isEnabled("joints") || isEnabled("frames") || isEnabled("colliders"))) draw(); });
on("event", ({ name }) => {
  if (name !== "stopped") return;
  contacts = [];
  draw();
});
controls.addEventListener("end", () => { if (enabled.size) draw(); });
for (const change of /** @type {const} */ (["scene", "objects", "selected"])) watch(change, () => { if (enabled.size) draw(); });

// The menu below the button, in which overlays are enabled.
const button = get("overlays");
const menu = get("overlay-menu");
for (const [kind, name] of Object.entries(KINDS)) {
  const box = make("input", { type: "checkbox", checked: enabled.has(kind) });
  const label = make("label");
  label.append(box, ` ${name}`);
  box.onchange = () => {
    if (box.checked) enabled.add(kind);
    else enabled.delete(kind);
    localStorage.setItem(KEY, [...enabled].join(" "));
    updateButton();
    requestData();
  };
  menu.append(label);
}
function updateButton() {
  button.classList.toggle("on", enabled.size > 0);
}
/** @param {boolean} open */
function showMenu(open) {
  menu.hidden = !open;
  button.setAttribute("aria-expanded", String(open));
}
button.onclick = () => showMenu(menu.hidden === true);
menu.addEventListener("keydown", (e) => {
  if (e.key !== "Escape") return;
  showMenu(false);
  button.focus();
});
addEventListener("pointerdown", (e) => {
  if (!menu.hidden && e.target instanceof Node && !menu.contains(e.target) && !button.contains(e.target)) showMenu(false);
}, true);
updateButton();
