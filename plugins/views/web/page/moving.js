// @ts-check
// Moving and turning what is selected, by arrows and rings in the view.

import { TransformControls } from "three/gizmo";
import { failure, newest } from "tatu/calls";
import { get } from "tatu/dom";
import { edit, named } from "tatu/edits";
import { groups } from "tatu/objects";
import { rights, selected, watch } from "tatu/store";
import { camera, controls, redraw, renderer, stage } from "tatu/view";
import { line } from "tatu/output";

const gizmo = new TransformControls(camera, renderer.domElement);
gizmo.setSpace("local");
stage.add(gizmo.getHelper());
/** @typedef {"translate" | "rotate"} Mode */
/** @type {[Mode, HTMLElement][]} */
const buttons = [["translate", get("move")], ["rotate", get("turn")]];
/** @type {Mode | ""} */
let mode = "";

function hold() {
  const group = groups.get(selected());
  if (mode && group && rights.acts) {
    gizmo.setMode(mode);
    gizmo.attach(group);
  } else gizmo.detach();
  for (const [m, b] of buttons) b.setAttribute("aria-pressed", String(m === mode));
  redraw();
}

for (const [m, b] of buttons) {
  b.onclick = () => { mode = mode === m ? "" : m; hold(); };
}
watch("selected", hold);
watch("scene", hold);
/** The number of the drag: what it changes is undone together. */
let drag = Date.now();
gizmo.addEventListener("dragging-changed", (e) => {
  controls.enabled = !e.value;
  drag++;
});
gizmo.addEventListener("change", redraw);

/** The newest pose, and whose it is: a drag may end on one object while a pose of it is still on the way. */
const move = newest(async (/** @type {{ id: number, pose: number[] }} */ { id, pose }) => {
  try {
    await edit(`Move ${named([id])}`, [["tatu.set", id, "object.pose", pose]], String(drag));
  } catch (e) {
    line("Status", failure(e).error, "error");
  }
});
gizmo.addEventListener("objectChange", () => {
  const group = gizmo.object;
  if (!group) return;
  const q = group.quaternion.clone().normalize();
  move({ id: group.userData.id, pose: [...group.position.toArray(), q.x, q.y, q.z, q.w] });
});
