// @ts-check
// Windows with camera images. Images of scene cameras are rendered by the page; those of vision sensors are received
// from the program.

import * as THREE from "three";
import { make } from "tatu/lib/dom";
import { floating } from "tatu/lib/floating_window";
import { image as readImage } from "tatu/net/binary_messages";
import { on, send } from "tatu/net/connection";
import { want } from "tatu/net/subscriptions";
import { objectAt, pathOf } from "tatu/scene/hierarchy";
import { scene } from "tatu/scene/store";
import { groups } from "tatu/view/objects";
import { alsoDraw, drawFrom, redraw } from "tatu/view/renderer";
import { gone, offer } from "tatu/windows/open_windows";

/** @typedef {{ object: string }} Spec */

/** Returns the description of the window for a camera or vision sensor. @param {number} id */
export function cameraSpec(id) {
  return { object: pathOf(id) };
}

/**
 * Returns whether an object is a camera or a sensor with images.
 * @param {number} id
 */
export function sees(id) {
  const o = scene.objects.get(id);
  return o?.kind === "camera" || o?.schema === "image";
}

/** @param {Spec} spec */
function openCamera(spec) {
  const id = objectAt(spec.object);
  const o = scene.objects.get(id);
  if (!o || !sees(id)) return null;
  const own = o.kind === "camera" ? drawn(id) : sent(id, `window ${spec.object}`);
  const window = floating({
    key: `camera ${spec.object}`, title: o.alias, width: 320, height: 270,
    closed: () => {
      own.close();
      gone(pane);
    },
  });
  const pane = { kind: "camera", spec, close: window.close };
  own.canvas.setAttribute("role", "img");
  own.canvas.setAttribute("aria-label", `What ${o.alias} sees`);
  window.body.append(own.canvas);
  redraw();
  return pane;
}
offer("camera", openCamera);

/** Rotation from scene cameras, which look along +z with y up, to those of three.js, which look along -z. */
const TURNED = new THREE.Quaternion(0, 1, 0, 0);
/** Default field of view of a scene camera, degrees. */
const ANGLE = 60;

/**
 * Creates a canvas with the image of a scene camera, which is rendered whenever the view is rendered.
 * @param {number} id
 */
function drawn(id) {
  const canvas = make("canvas", { className: "seen" });
  const camera = new THREE.PerspectiveCamera(ANGLE, 1, 0.02, 2000);
  let angle = ANGLE;
  const draw = () => {
    const group = groups.get(id);
    const [w, h] = [canvas.clientWidth, canvas.clientHeight];
    if (!group || !w || !h) return;
    group.matrixWorld.decompose(camera.position, camera.quaternion, camera.scale);
    camera.quaternion.multiply(TURNED);
    camera.aspect = w / h;
    // The field of view applies to the longer side of the image.
    const half = Math.tan((angle * Math.PI) / 360);
    camera.fov = (360 / Math.PI) * Math.atan(w > h ? half / camera.aspect : half);
    camera.scale.setScalar(1);
    camera.updateProjectionMatrix();
    drawFrom(camera, canvas);
  };
  details.set(id, (rows) => {
    const row = rows.find((r) => r.key === "camera.angle");
    if (typeof row?.value === "number") angle = (row.value * 180) / Math.PI;
    redraw();
  });
  send({ type: "details", object: id });
  const sized = new ResizeObserver(redraw);
  sized.observe(canvas);
  const stop = alsoDraw(draw);
  return { canvas, close: () => {
    stop();
    sized.disconnect();
    details.delete(id);
  } };
}
/** @type {Map<number, (rows: import("tatu/protocol").PropertyRow[]) => void>} */
const details = new Map();
on("details", ({ object, rows }) => details.get(object)?.(rows));

/**
 * Creates a canvas with the images of a vision sensor, and requests these images from the program.
 * @param {number} id
 * @param {string} who unique name of the window
 */
function sent(id, who) {
  const canvas = make("canvas", { className: "seen sent", width: 4, height: 3 });
  images.set(who, { id, canvas });
  want("images", who, id);
  return { canvas, close: () => {
    images.delete(who);
    want("images", who, 0);
  } };
}
/** @type {Map<string, { id: number, canvas: HTMLCanvasElement }>} */
const images = new Map();
on("image", (view) => {
  const of = view.getUint32(4, true);
  for (const { id, canvas } of images.values()) {
    if (id !== of) continue;
    const { width, height, pixels } = readImage(view);
    if (!width || !height) continue;
    Object.assign(canvas, { width, height });
    canvas.getContext("2d")?.putImageData(new ImageData(pixels, width, height), 0, 0);
  }
});
