// @ts-check
// Windows with camera images. Images of scene cameras are rendered by the page; those of vision sensors are received
// from the program.

import * as THREE from "three";
import { make } from "tatu/lib/dom";
import { openFloatingWindow } from "tatu/lib/floating_window";
import { t } from "tatu/lib/language";
import { parseImage } from "tatu/net/binary_messages";
import { on, send } from "tatu/net/connection";
import { subscribe } from "tatu/net/subscriptions";
import { objectAt, pathOf } from "tatu/scene/hierarchy";
import { scene, showsDepth } from "tatu/scene/store";
import { groups } from "tatu/view/objects";
import { beforeDrawing, drawFromCamera, redraw } from "tatu/view/renderer";
import { registerWindow, storeWindows, windowClosed } from "tatu/windows/open_windows";

/** The object, and whether the window shows its depths, if the user has chosen. @typedef {{ object: string, depth?: boolean }} Spec */

/** Returns the description of the window for a camera or vision sensor. @param {number} id */
export function cameraSpec(id) {
  return { object: pathOf(id) };
}

/**
 * Returns whether an object is a camera or a sensor with images.
 * @param {number} id
 */
export function hasImage(id) {
  const o = scene.objects.get(id);
  return o?.kind === "camera" || o?.schema === "image";
}

/** @param {Spec} spec */
function openCamera(spec) {
  const id = objectAt(spec.object);
  const o = scene.objects.get(id);
  if (!o || !hasImage(id)) return null;
  const content = o.kind === "camera" ? renderedCanvas(id) : receivedCanvas(id, spec, (text) => { window.title.textContent = `${o.alias} \u2014 ${text}`; });
  const window = openFloatingWindow({
    key: `camera ${spec.object}`, title: o.alias, width: 320, height: 270,
    closed: () => {
      content.close();
      windowClosed(opened);
    },
  });
  const opened = { kind: "camera", spec, close: window.close };
  content.canvas.setAttribute("role", "img");
  content.canvas.setAttribute("aria-label", t`What ${o.alias} sees`);
  if (content.tools) window.body.append(content.tools);
  window.body.append(content.canvas);
  redraw();
  return opened;
}
registerWindow("camera", openCamera, (spec) => spec.object);

/** Rotation from scene cameras, which look along +z with y up, to those of three.js, which look along -z. */
const CAMERA_ROTATION = new THREE.Quaternion(0, 1, 0, 0);
/** Default field of view of a scene camera, degrees. */
const DEFAULT_ANGLE = 60;

/**
 * Creates a canvas with the image of a scene camera, which is rendered whenever the view is rendered.
 * @param {number} id
 */
function renderedCanvas(id) {
  const canvas = make("canvas", { className: "seen" });
  const camera = new THREE.PerspectiveCamera(DEFAULT_ANGLE, 1, 0.02, 2000);
  let angle = DEFAULT_ANGLE;
  const draw = () => {
    const group = groups.get(id);
    const [w, h] = [canvas.clientWidth, canvas.clientHeight];
    if (!group || !w || !h) return;
    group.matrixWorld.decompose(camera.position, camera.quaternion, camera.scale);
    camera.quaternion.multiply(CAMERA_ROTATION);
    camera.aspect = w / h;
    // The field of view applies to the longer side of the image.
    const half = Math.tan((angle * Math.PI) / 360);
    camera.fov = (360 / Math.PI) * Math.atan(w > h ? half / camera.aspect : half);
    camera.scale.setScalar(1);
    camera.updateProjectionMatrix();
    drawFromCamera(camera, canvas);
  };
  detailListeners.set(id, (rows) => {
    const row = rows.find((r) => r.key === "camera.angle");
    if (typeof row?.value === "number") angle = (row.value * 180) / Math.PI;
    redraw();
  });
  send({ type: "details", object: id });
  const sizeObserver = new ResizeObserver(redraw);
  sizeObserver.observe(canvas);
  const stop = beforeDrawing(draw);
  return { canvas, tools: null, close: () => {
    stop();
    sizeObserver.disconnect();
    detailListeners.delete(id);
  } };
}
/** @type {Map<number, (rows: import("tatu/protocol").PropertyRow[]) => void>} */
const detailListeners = new Map();
on("details", ({ object, rows }) => detailListeners.get(object)?.(rows));

/**
 * Creates a canvas with the images of a vision sensor, and requests these images from the program. If the sensor measures
 * colors and depths, `tools` has the choice between them, and the scale of the depths.
 * @param {number} id
 * @param {Spec} spec
 * @param {(text: string) => void} showSize shows the size of the image
 */
function receivedCanvas(id, spec, showSize) {
  const subscriber = `window ${spec.object}`;
  const canvas = make("canvas", { className: "seen sent", width: 4, height: 3 });
  const o = scene.objects.get(id);
  const hasBoth = o?.depth === true;
  const isDepthShown = () => hasBoth && (spec.depth ?? showsDepth(o));
  const scale = make("span", { className: "depth-scale", hidden: true });
  const [nearText, farText] = [make("span"), make("span")];
  scale.append(nearText, make("span", { className: "ramp" }), farText);
  const request = () => {
    scale.hidden = true;
    subscribe("images", subscriber, isDepthShown() ? 0 : id);
    subscribe("depths", subscriber, isDepthShown() ? id : 0);
  };
  const choice = make("select", { title: t`What the image shows` });
  choice.setAttribute("aria-label", t`What the image shows`);
  choice.add(new Option(t`colors`, "colors"));
  choice.add(new Option(t`depth`, "depth"));
  choice.value = isDepthShown() ? "depth" : "colors";
  choice.onchange = () => {
    spec.depth = choice.value === "depth";
    request();
    storeWindows();
  };
  let hasColors = false;
  const tools = make("div", { className: "tools" });
  tools.append(choice, scale);
  images.set(subscriber, { id, show: ({ isDepth, near, far, width, height, pixels }) => {
    // Both may arrive, since another part of the page may show the other one. Some sensors do not measure their colors.
    hasColors ||= !isDepth;
    if (hasBoth && (isDepthShown() ? !isDepth : isDepth && hasColors)) return;
    Object.assign(canvas, { width, height });
    showSize(`${width} \u00d7 ${height}`);
    scale.hidden = !isDepth;
    nearText.textContent = `${+near.toPrecision(3)} m`;
    farText.textContent = `${+far.toPrecision(3)} m`;
    canvas.getContext("2d")?.putImageData(new ImageData(pixels, width, height), 0, 0);
  } });
  request();
  return { canvas, tools: hasBoth ? tools : null, close: () => {
    images.delete(subscriber);
    subscribe("images", subscriber, 0);
    subscribe("depths", subscriber, 0);
  } };
}
/** @type {Map<string, { id: number, show: (image: ReturnType<typeof parseImage>) => void }>} */
const images = new Map();
on("image", (view) => {
  const sensor = view.getUint32(4, true);
  const shown = [...images.values()].filter(({ id }) => id === sensor);
  if (!shown.length) return;
  const image = parseImage(view);
  if (image.width && image.height) for (const { show } of shown) show(image);
});
