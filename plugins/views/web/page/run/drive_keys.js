// @ts-check
// Drives the selected robot by the arrow keys, if it declares its drivetrain.

import { get } from "tatu/lib/dom";
import { call } from "tatu/net/connection";
import { limited } from "tatu/scene/edits";
import { rights, scene, selected, watch } from "tatu/scene/store";

/** Wheel speeds for driving straight and for turning on the spot, rad/s. */
const [AHEAD, TURN] = [4, 2];
/** @type {{ [key: string]: [number, number] | undefined }} */
const WAYS = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] };
/** @typedef {{ id: number, type: string, radius: number, wheelbase: number, track: number }} Robot */
/** @type {Set<string>} */
const pressed = new Set();
/** @type {Robot | null} */
let robot = null;
let told = "";

/** Sets `robot` to the selected object or the nearest object above it that has a drivetrain, or to null. */
async function find() {
  const before = robot;
  robot = null;
  if (before) stop(before);
  if (!rights.acts || limited()) return;
  const at = selected();
  for (let o = scene.objects.get(at); o; o = scene.objects.get(o.parent)) {
    const [drive] = await call("tatu.get", o.id, "object.drive").catch(() => [null]);
    if (selected() !== at) return;
    if (drive?.type) {
      robot = { id: o.id, ...drive };
      return;
    }
  }
}

/** Stops a robot that is being driven. @param {Robot} of */
function stop(of) {
  pressed.clear();
  if (told && told !== "0,0") call("tatu.drive", of.id, 0, 0, 0).catch(() => {});
  told = "";
}

function steer() {
  let [ahead, left] = [0, 0];
  for (const key of pressed) {
    const [a, l] = WAYS[key] ?? [0, 0];
    ahead += a;
    left += l;
  }
  const now = `${ahead},${left}`;
  if (!robot || now === told) return;
  told = now;
  const way = ahead * AHEAD * robot.radius;
  // An Ackermann robot turns only while it drives, and its turning direction is reversed when it drives backwards.
  const turn = robot.type === "ackermann" ? left * way * 0.8 / robot.wheelbase : left * 2 * TURN * robot.radius / robot.track;
  call("tatu.drive", robot.id, way, 0, turn).catch(() => {});
}

get("view").addEventListener("keydown", (e) => {
  if (!(e.key in WAYS) || e.ctrlKey || e.metaKey || e.altKey) return;
  pressed.add(e.key);
  steer();
});
addEventListener("keyup", (e) => { if (pressed.delete(e.key)) steer(); });
addEventListener("blur", () => { if (robot) stop(robot); });
watch("selected", find);
