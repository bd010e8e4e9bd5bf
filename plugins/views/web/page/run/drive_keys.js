// @ts-check
// Drives the selected robot by the arrow keys, if it declares its drivetrain.

import { get } from "tatu/lib/dom";
import { call } from "tatu/net/connection";
import { isScriptsOnly } from "tatu/scene/edits";
import { rights, scene, selected, watch } from "tatu/scene/store";

/** Wheel speeds for driving straight and for turning on the spot, rad/s. */
const [FORWARD_SPEED, TURN_SPEED] = [4, 2];
/** @type {{ [key: string]: [number, number] | undefined }} */
const DIRECTIONS = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] };
/** @typedef {{ id: number, type: string, radius: number, wheelbase: number, track: number }} Robot */
/** @type {Set<string>} */
const pressed = new Set();
/** @type {Robot | null} */
let robot = null;
let sentDirection = "";

/** Sets `robot` to the selected object or the nearest object above it that has a drivetrain, or to null. */
async function findRobot() {
  const previous = robot;
  robot = null;
  if (previous) stop(previous);
  if (!rights.canControl || isScriptsOnly()) return;
  const id = selected();
  for (let o = scene.objects.get(id); o; o = scene.objects.get(o.parent)) {
    const [drive] = await call("tatu.get", o.id, "object.drive").catch(() => [null]);
    if (selected() !== id) return;
    if (drive?.type) {
      robot = { id: o.id, ...drive };
      return;
    }
  }
}

/** Stops a robot that is being driven. @param {Robot} driven */
function stop(driven) {
  pressed.clear();
  if (sentDirection && sentDirection !== "0,0") call("tatu.drive", driven.id, 0, 0, 0).catch(() => {});
  sentDirection = "";
}

function steer() {
  let [forward, left] = [0, 0];
  for (const key of pressed) {
    const [f, l] = DIRECTIONS[key] ?? [0, 0];
    forward += f;
    left += l;
  }
  const direction = `${forward},${left}`;
  if (!robot || direction === sentDirection) return;
  sentDirection = direction;
  const speed = forward * FORWARD_SPEED * robot.radius;
  // An Ackermann robot turns only while it drives, and its turning direction is reversed when it drives backwards.
  const turn = robot.type === "ackermann" ? left * speed * 0.8 / robot.wheelbase : left * 2 * TURN_SPEED * robot.radius / robot.track;
  call("tatu.drive", robot.id, speed, 0, turn).catch(() => {});
}

get("view").addEventListener("keydown", (e) => {
  if (!(e.key in DIRECTIONS) || e.ctrlKey || e.metaKey || e.altKey) return;
  pressed.add(e.key);
  steer();
});
addEventListener("keyup", (e) => { if (pressed.delete(e.key)) steer(); });
addEventListener("blur", () => { if (robot) stop(robot); });
watch("selected", findRobot);
