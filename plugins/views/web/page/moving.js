// Moving and turning what is selected, by arrows and rings in the view.

import { TransformControls } from "three/gizmo";
import { call } from "tatu/net";
import { groups } from "tatu/objects";
import { changed, rights, selected, watch } from "tatu/store";
import { camera, controls, redraw, renderer, stage } from "tatu/view";
import { line } from "tatu/output";

const gizmo = new TransformControls(camera, renderer.domElement);
gizmo.setSpace("local");
stage.add(gizmo.getHelper());
const buttons = { translate: document.getElementById("move"), rotate: document.getElementById("turn") };
let mode = "";

function hold() {
  const group = groups.get(selected());
  if (mode && group && rights.acts) {
    gizmo.setMode(mode);
    gizmo.attach(group);
  } else gizmo.detach();
  for (const [m, b] of Object.entries(buttons)) b.setAttribute("aria-pressed", String(m === mode));
  redraw();
}

for (const [m, b] of Object.entries(buttons)) {
  b.onclick = () => { mode = mode === m ? "" : m; hold(); };
}
watch("selected", hold);
watch("scene", hold);
gizmo.addEventListener("dragging-changed", (e) => { controls.enabled = !e.value; });
gizmo.addEventListener("change", redraw);

let sending = false;
gizmo.addEventListener("objectChange", async () => {
  if (sending) return;
  sending = true;
  const group = gizmo.object;
  const p = group.position;
  const q = group.quaternion.clone().normalize();
  try {
    await call("tatu.set", selected(), "object.pose", [p.x, p.y, p.z, q.x, q.y, q.z, q.w]);
    changed();
  } catch (e) {
    line("Status", e.error, "error");
  }
  sending = false;
});
