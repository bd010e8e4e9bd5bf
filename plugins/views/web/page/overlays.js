// @ts-check
// What can be drawn over the scene: contacts with their forces, centres of mass, velocities, axes of joints, frames.

import * as THREE from "three";
import { get, make } from "tatu/dom";
import { on, send } from "tatu/net";
import { groups } from "tatu/objects";
import { scene, selection, watch } from "tatu/store";
import { camera, controls, redraw, stage } from "tatu/view";

/** @import { BodyMark, ContactMark } from "tatu/protocol" */

const KINDS = /** @type {const} */ ({
  contacts: "Contacts and forces",
  masses: "Centres of mass",
  velocities: "Velocities",
  joints: "Axes of joints",
  frames: "Frames of the selection",
});
/** @typedef {keyof typeof KINDS} Kind */

const KEY = "tatu overlays";
/** @type {Set<string>} */
const wanted = new Set((localStorage.getItem(KEY) ?? "").split(" ").filter((kind) => kind in KINDS));
const is = (/** @type {Kind} */ kind) => wanted.has(kind);

const all = new THREE.Group();
all.renderOrder = 2;
stage.add(all);
const line = (/** @type {number} */ color) => new THREE.LineBasicMaterial({ color, depthTest: false, transparent: true });
const FORCE = line(0xe0352b);
const SPEED = line(0x2b7de0);
const AXIS = line(0xb35900);
const POINT = new THREE.PointsMaterial({ color: 0xe0352b, size: 6, sizeAttenuation: false, depthTest: false, transparent: true });
const MASS = new THREE.MeshBasicMaterial({ color: 0xf2c500, depthTest: false, transparent: true, opacity: 0.9 });
const BALL = new THREE.SphereGeometry(1, 12, 8);

/** @type {ContactMark[]} */
let contacts = [];
/** @type {BodyMark[]} */
let bodies = [];

/**
 * Arrows as segments: a shaft and two strokes at its end, across the view.
 * @param {THREE.Vector3[]} out
 * @param {THREE.Vector3} from
 * @param {THREE.Vector3} way
 */
function arrow(out, from, way) {
  const length = way.length();
  if (length < 1e-6) return;
  const to = from.clone().add(way);
  const side = way.clone().cross(camera.position.clone().sub(from)).setLength(0.12 * length);
  const back = to.clone().addScaledVector(way, -0.22);
  out.push(from, to, to, back.clone().add(side), to, back.sub(side));
}

/**
 * @param {THREE.Vector3[]} ends
 * @param {THREE.LineBasicMaterial} material
 */
function segments(ends, material) {
  if (ends.length) all.add(new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(ends), material));
}

/** Draws everything that is wanted anew; sizes are parts of the view. */
function draw() {
  for (const child of all.children) {
    if (child instanceof THREE.LineSegments || child instanceof THREE.Points) child.geometry.dispose();
  }
  all.clear();
  const view = camera.position.distanceTo(controls.target) * Math.tan((camera.fov * Math.PI) / 360);
  if (is("contacts") && contacts.length) {
    const points = contacts.map((c) => new THREE.Vector3(...c.point));
    all.add(new THREE.Points(new THREE.BufferGeometry().setFromPoints(points), POINT));
    // The largest force is a quarter of the view long, unless all are small.
    const most = Math.max(1, ...contacts.map((c) => Math.hypot(...c.force)));
    /** @type {THREE.Vector3[]} */
    const ends = [];
    contacts.forEach((c, i) => { const at = points[i]; if (at) arrow(ends, at, new THREE.Vector3(...c.force).multiplyScalar((0.35 * view) / most)); });
    segments(ends, FORCE);
  }
  /** @type {THREE.Vector3[]} */
  const speeds = [];
  for (const b of bodies) {
    const group = groups.get(b.id);
    if (!group || !(is("masses") || is("velocities"))) continue;
    const center = group.localToWorld(new THREE.Vector3(...b.com));
    if (is("masses") && b.mass > 0) {
      const ball = new THREE.Mesh(BALL, MASS);
      ball.position.copy(center);
      ball.scale.setScalar(Math.min(0.03 * view, 0.012 * Math.cbrt(b.mass) + 0.006 * view));
      all.add(ball);
    }
    // A second's way, at most half of the view.
    if (is("velocities")) arrow(speeds, center, new THREE.Vector3(...b.velocity).clampLength(0, 0.5 * view));
  }
  segments(speeds, SPEED);
  if (is("joints")) {
    /** @type {THREE.Vector3[]} */
    const ends = [];
    for (const o of scene.objects.values()) {
      const group = o.kind === "joint" ? groups.get(o.id) : null;
      if (group) ends.push(...[-1, 1].map((side) => group.localToWorld(new THREE.Vector3(0, 0, 0.06 * view * side))));
    }
    segments(ends, AXIS);
  }
  if (is("frames")) {
    for (const id of selection()) {
      const group = groups.get(id);
      if (!group) continue;
      const axes = new THREE.AxesHelper(0.15 * view);
      for (const material of [axes.material].flat()) Object.assign(material, { depthTest: false, transparent: true });
      group.updateWorldMatrix(true, false);
      group.matrixWorld.decompose(axes.position, axes.quaternion, axes.scale);
      axes.scale.set(1, 1, 1);
      all.add(axes);
    }
  }
  redraw();
}

function ask() {
  send({ type: "overlays", contacts: is("contacts"), bodies: is("masses") || is("velocities") });
  if (!is("contacts")) contacts = [];
  if (!is("masses") && !is("velocities")) bodies = [];
  draw();
}

on("overlays", (message) => {
  ({ contacts, bodies } = message);
  draw();
});
on("hello", () => { if (wanted.size) ask(); });
on("frame", () => { if (wanted.size && (is("joints") || is("frames"))) draw(); });
on("event", ({ name }) => {
  if (name !== "stopped") return;
  contacts = [];
  draw();
});
controls.addEventListener("end", () => { if (wanted.size) draw(); });
for (const news of /** @type {const} */ (["scene", "selected"])) watch(news, () => { if (wanted.size) draw(); });

// The menu below the button.
const button = get("overlays");
const menu = get("overlay-menu");
for (const [kind, name] of Object.entries(KINDS)) {
  const box = make("input", { type: "checkbox", checked: wanted.has(kind) });
  const label = make("label");
  label.append(box, ` ${name}`);
  box.onchange = () => {
    if (box.checked) wanted.add(kind);
    else wanted.delete(kind);
    localStorage.setItem(KEY, [...wanted].join(" "));
    mark();
    ask();
  };
  menu.append(label);
}
function mark() {
  button.classList.toggle("on", wanted.size > 0);
}
/** @param {boolean} open */
function show(open) {
  menu.hidden = !open;
  button.setAttribute("aria-expanded", String(open));
}
button.onclick = () => show(menu.hidden === true);
menu.addEventListener("keydown", (e) => {
  if (e.key !== "Escape") return;
  show(false);
  button.focus();
});
addEventListener("pointerdown", (e) => {
  if (!menu.hidden && e.target instanceof Node && !menu.contains(e.target) && !button.contains(e.target)) show(false);
});
mark();
