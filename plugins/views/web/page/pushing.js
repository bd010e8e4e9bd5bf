// @ts-check
// Pushing bodies: Shift and a drag pull what is under the pointer, as a spring would.

import * as THREE from "three";
import { call, on } from "tatu/net";
import { groups } from "tatu/objects";
import { timeOf } from "tatu/parse";
import { rights, scene } from "tatu/store";
import { camera, controls, hitAt, redraw, renderer, rayAt, stage } from "tatu/view";

/** Spring and damper for each kg, in N/m and N s/m, and the largest force for each kg, in N. */
const [SPRING, DAMPER, MOST] = [60, 10, 30];
/** How much of the torque acts: with all of it what is seen late would spin. */
const TURN = 0.3;
const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3()]), new THREE.LineBasicMaterial({ color: 0xff7a00, depthTest: false }));
line.visible = line.frustumCulled = false;
stage.add(line);
/** @import { ObjectGroup } from "tatu/crowd" */
/**
 * What is held: the body and its mass, the point of it in its frame, where the pointer is, and where the point was.
 * @typedef {{ id: number, mass: number, group: ObjectGroup, plane: THREE.Plane, point: THREE.Vector3, goal: THREE.Vector3, before: { here: THREE.Vector3, time: number } | null }} Held
 */
/** @type {Held | null} */
let held = null;
/** The number of the drag: what is asked at its beginning may come when it has ended. */
let drag = 0;

/**
 * The body that carries an object, with the mass of all that moves as one.
 * @param {number} id
 */
async function bodyOf(id) {
  for (let o = scene.objects.get(id); o; o = scene.objects.get(o.parent)) {
    if (o.kind !== "shape") continue;
    const [dynamic] = await call("tatu.get", o.id, "shape.dynamic");
    if (dynamic) return { id: o.id, mass: (await call("tatu.get", o.id, "shape.mass"))[0] };
  }
  return null;
}

const canvas = renderer.domElement;
canvas.addEventListener("pointerdown", async (e) => {
  if (!e.shiftKey || e.button !== 0 || !rights.acts) return;
  const hit = hitAt(e);
  if (!hit) return;
  controls.enabled = false;
  const own = ++drag;
  const body = await bodyOf(hit.id).catch(() => null);
  if (own !== drag) return;
  const group = groups.get(body?.id ?? 0);
  if (!body || !group) {
    release();
    return;
  }
  const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new THREE.Vector3()), hit.point);
  held = { ...body, group, plane, point: group.worldToLocal(hit.point.clone()), goal: hit.point.clone(), before: null };
}, true);
canvas.addEventListener("pointermove", (e) => {
  if (!held) return;
  rayAt(e).ray.intersectPlane(held.plane, held.goal);
  redraw();
});
function release() {
  drag++;
  held = null;
  line.visible = false;
  controls.enabled = true;
  redraw();
}
for (const kind of ["pointerup", "pointercancel"]) addEventListener(kind, release);

on("frame", (view) => {
  if (!held) return;
  const time = timeOf(view);
  held.group.updateWorldMatrix(true, false);
  const here = held.group.localToWorld(held.point.clone());
  const way = held.goal.clone().sub(here);
  const { before } = held;
  const passed = before ? time - before.time : 0;
  const force = way.clone().multiplyScalar(SPRING * held.mass);
  if (before && passed > 0) force.addScaledVector(here.clone().sub(before.here), (-DAMPER * held.mass) / passed);
  force.clampLength(0, MOST * held.mass);
  held.before = { here, time };
  line.geometry.setFromPoints([here, held.goal]);
  line.visible = true;
  if (passed <= 0) return;
  // In the frame of the world: the body has turned a little further than what is seen of it.
  const arm = here.clone().sub(held.group.getWorldPosition(new THREE.Vector3()));
  call("sim.addForceAndTorque", held.id, force.toArray(), arm.cross(force).multiplyScalar(TURN).toArray()).catch(release);
});
