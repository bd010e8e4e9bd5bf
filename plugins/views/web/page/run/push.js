// @ts-check
// Pushes bodies: during a drag with Shift, a virtual spring pulls the body towards the pointer.

import * as THREE from "three";
import { get, make } from "tatu/lib/dom";
import { t } from "tatu/lib/language";
import { positionOf, rotationOf } from "tatu/lib/poses";
import { conjugate, rotate } from "tatu/lib/rotations";
import { cross, minus, plus } from "tatu/lib/vectors";
import { timeOf } from "tatu/net/binary_messages";
import { call, on } from "tatu/net/connection";
import { isScriptsOnly } from "tatu/scene/edits";
import { rights, scene } from "tatu/scene/store";
import { groups } from "tatu/view/objects";
import { hitAt, rayAt } from "tatu/view/picking";
import { camera, controls, redraw, renderer, stage } from "tatu/view/renderer";
import { INITIAL_BOUND, MAX_BOUND, angleBetween, nextBound, springForce, tiltFactor, uprightTorque } from "tatu/run/push_force";

/** @import { Vec3 } from "tatu/lib/vectors" */
/**
 * The held body. `mass` (kg) includes attached bodies; `com` and `point` are the centre of mass and the held point in
 * the frame of the body, m. `goal` is the position of the pointer on `plane` in the world frame; `bound` is the maximum
 * force per mass, N/kg; `time` is that of the last pull, s. `rolls` is whether the form rolls; `up` is the direction,
 * in the frame of the body, that pointed up at the first pull.
 * @typedef {{ id: number, mass: number, com: Vec3, plane: THREE.Plane, point: Vec3, goal: THREE.Vector3, bound: number, time: number | null, rolls: boolean, up: Vec3 | null }} HeldBody
 */
/** @type {HeldBody | null} */
let heldBody = null;
/** Number of the drag. Answers to requests that were sent at the start of an earlier drag are ignored. */
let drag = 0;
/** @type {Vec3} */
const UP = [0, 0, 1];
/** Forms that roll instead of tipping over. */
const ROUND = ["sphere", "cylinder", "capsule"];
/** Maximum time that a single pull makes up for, s. It keeps a page that has stalled from pulling too hard afterwards. */
const MAX_PULL_TIME = 0.05;
/** Radius of the arrow for no force and for the maximum force, relative to its distance from the camera. */
const [THIN_RADIUS, THICK_RADIUS] = [0.003, 0.009];
/** Color of the arrow for no force and for the maximum force. */
const [WEAK_COLOR, STRONG_COLOR] = [new THREE.Color(0xffc400), new THREE.Color(0xe02000)];

const material = new THREE.MeshBasicMaterial({ color: WEAK_COLOR, depthTest: false, transparent: true, opacity: 0.85 });
const shaft = new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0), material);
const tip = new THREE.Mesh(new THREE.ConeGeometry(2.6, 6, 16).translate(0, -3, 0), material);
const arrow = new THREE.Group();
arrow.add(shaft, tip);
arrow.visible = false;
stage.add(arrow);
const label = make("output", { className: "push", hidden: true });
label.setAttribute("aria-label", t`Force of the push`);
get("view").append(label);

/** Returns the components of a vector. @param {THREE.Vector3} v @returns {Vec3} */
const numbers = (v) => [v.x, v.y, v.z];

/**
 * Draws the arrow from the held point of the body to the pointer.
 * @param {HeldBody} body
 * @param {THREE.Vector3} heldPoint the held point in the world frame
 * @param {number} force N
 */
function draw({ goal, mass }, heldPoint, force) {
  const vector = goal.clone().sub(heldPoint);
  const part = Math.min(1, force / (MAX_BOUND * mass));
  const radius = camera.position.distanceTo(heldPoint) * (THIN_RADIUS + (THICK_RADIUS - THIN_RADIUS) * part);
  arrow.position.copy(heldPoint);
  arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), vector.clone().normalize());
  shaft.scale.set(radius, Math.max(1e-6, vector.length() - 5 * radius), radius);
  tip.position.y = vector.length();
  tip.scale.setScalar(radius);
  material.color.lerpColors(WEAK_COLOR, STRONG_COLOR, part);
  arrow.visible = vector.length() > 1e-4;
  const [at, box] = [goal.clone().project(camera), renderer.domElement];
  label.style.left = `${((at.x + 1) / 2) * box.clientWidth + 14}px`;
  label.style.top = `${((1 - at.y) / 2) * box.clientHeight + 10}px`;
  label.textContent = `${force < 10 ? force.toFixed(1) : force.toFixed(0)} N`;
  label.hidden = false;
  redraw();
}

/**
 * Returns a promise of the total mass of a shape and all shapes below it, kg. Static shapes are not counted.
 * @param {number} id
 * @returns {Promise<number>}
 */
async function massOf(id) {
  const isBelow = (/** @type {number} */ other) => {
    for (let o = scene.objects.get(other); o; o = scene.objects.get(o.parent)) if (o.id === id) return true;
    return false;
  };
  const shapes = [...scene.objects.values()].filter((o) => o.kind === "shape" && isBelow(o.id));
  const masses = await Promise.all(shapes.map(async (o) => {
    const [dynamic] = await call("tatu.get", o.id, "shape.dynamic");
    return dynamic ? (await call("tatu.get", o.id, "shape.mass"))[0] : 0;
  }));
  return masses.reduce((sum, m) => sum + m, 0);
}

/**
 * Returns a promise of the dynamic shape to which an object belongs (the object itself or the nearest one above it), or
 * of null.
 * @param {number} id
 */
async function bodyOf(id) {
  for (let o = scene.objects.get(id); o; o = scene.objects.get(o.parent)) {
    if (o.kind !== "shape" || !(await call("tatu.get", o.id, "shape.dynamic"))[0]) continue;
    const [[com], [form], mass] = await Promise.all([call("tatu.get", o.id, "shape.com"), call("tatu.get", o.id, "shape.primitive"), massOf(o.id)]);
    return { id: o.id, mass, com, rolls: ROUND.includes(form) };
  }
  return null;
}

const canvas = renderer.domElement;
canvas.addEventListener("pointerdown", async (e) => {
  if (!e.shiftKey || e.button !== 0 || !rights.canControl || isScriptsOnly()) return;
  const hit = hitAt(e);
  if (!hit) return;
  controls.enabled = false;
  const number = ++drag;
  const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new THREE.Vector3()), hit.point);
  const goal = hit.point.clone();
  // The pointer is tracked while the request is pending.
  const follow = (/** @type {PointerEvent} */ at) => { rayAt(at).ray.intersectPlane(plane, goal); };
  canvas.addEventListener("pointermove", follow);
  const body = await bodyOf(hit.id).catch(() => null);
  canvas.removeEventListener("pointermove", follow);
  if (number !== drag) return;
  const group = groups.get(body?.id ?? 0);
  if (!body || !group) {
    release();
    return;
  }
  heldBody = { ...body, plane, point: numbers(group.worldToLocal(hit.point.clone())), goal, bound: INITIAL_BOUND, time: null, up: null };
}, true);
canvas.addEventListener("pointermove", (e) => {
  if (!heldBody) return;
  rayAt(e).ray.intersectPlane(heldBody.plane, heldBody.goal);
  redraw();
});
/** Ends the drag. */
function release() {
  drag++;
  heldBody = null;
  arrow.visible = false;
  label.hidden = true;
  controls.enabled = true;
  redraw();
}
for (const kind of ["pointerup", "pointercancel"]) addEventListener(kind, release);

/**
 * Pulls the body once. The force is computed from the state that the program returns, because poses in frames are
 * rounded and may be outdated.
 * @param {HeldBody} body
 * @param {number} elapsed simulation time since the last pull, s
 */
async function pullOnce(body, elapsed) {
  const [[pose], [linear, angular]] = await Promise.all([call("tatu.get", body.id, "object.world_pose"), call("sim.getVelocity", body.id)]);
  if (heldBody !== body) return;
  const rotation = rotationOf(pose);
  const center = plus(positionOf(pose), rotate(rotation, body.com));
  const heldPoint = plus(positionOf(pose), rotate(rotation, body.point));
  const arm = minus(heldPoint, center);
  const velocity = plus(linear, cross(angular, arm));
  const displacement = minus(numbers(body.goal), heldPoint);
  body.up ??= rotate(conjugate(rotation), UP);
  const part = body.rolls ? 1 : tiltFactor(angleBetween(UP, rotate(rotation, body.up)));
  /** @type {Vec3} */
  const force = [0, 0, 0];
  springForce(displacement, velocity, body.mass, body.bound).forEach((x, i) => { force[i] = part * x; });
  body.bound = nextBound(body.bound, displacement, velocity, elapsed);
  draw(body, new THREE.Vector3(...heldPoint), Math.hypot(...force));
  // The program applies a force for one step only, so it is multiplied by the number of steps since the last pull.
  const steps = Math.max(1, elapsed / scene.dt);
  const times = (/** @type {Vec3} */ v) => v.map((x) => x * steps);
  await call("sim.addForceAndTorque", body.id, times(force), times(uprightTorque(arm, force)));
}

let isActing = false;
on("frame", async (view) => {
  const body = heldBody;
  if (!body || isActing) return;
  const time = timeOf(view);
  const elapsed = Math.min(MAX_PULL_TIME, time - (body.time ?? time));
  body.time = time;
  if (elapsed <= 0) return;
  isActing = true;
  await pullOnce(body, elapsed).catch(release);
  isActing = false;
});
