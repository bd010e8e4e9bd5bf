// @ts-check
// Takes pictures of the scene, which the gallery shows for recent scenes.

import { get } from "tatu/lib/dom";
import { on, send } from "tatu/net/connection";
import { rights, scene, watch } from "tatu/scene/store";
import { drawn, renderer } from "tatu/view/renderer";

/**
 * Sizes of pictures in pixels, tried in order until the picture is within the program's limit.
 * @type {[number, number][]}
 */
const SIZES = [[240, 150], [160, 100]];
/** Maximum size of a picture, bytes. */
const MAX_BYTES = 64 << 10;
/** Delay between the arrival of a scene and its first picture, ms. */
const FIRST_DELAY = 3000;
/** Interval of further pictures, ms. */
const INTERVAL = 20000;
/** Number of the image in the view (`drawn`) when the last picture was sent. */
let sentDrawing = 0;

/**
 * Returns the middle of the view as a PNG in base64.
 * @param {[number, number]} size pixels
 */
function picture([width, height]) {
  const from = renderer.domElement;
  const to = Object.assign(document.createElement("canvas"), { width, height });
  const scale = Math.min(from.width / width, from.height / height);
  const [w, h] = [width * scale, height * scale];
  to.getContext("2d")?.drawImage(from, (from.width - w) / 2, (from.height - h) / 2, w, h, 0, 0, width, height);
  return to.toDataURL("image/png").split(",")[1] ?? "";
}

/** Sends a picture of the scene, unless the view has not been rendered since the last picture. */
export function sendPicture() {
  const { width, height } = renderer.domElement;
  if (!rights.canControl || !scene.objects.size || drawn === sentDrawing || !width || !height) return;
  const png = SIZES.map(picture).find((text) => text.length * 0.75 <= MAX_BYTES);
  if (!png) return;
  sentDrawing = drawn;
  send({ type: "picture", scene: scene.file, png });
}

let file = "";
watch("scene", () => {
  if (scene.file === file) return;
  file = scene.file;
  setTimeout(sendPicture, FIRST_DELAY);
});
setInterval(() => { if (!document.hidden) sendPicture(); }, INTERVAL);
document.addEventListener("visibilitychange", () => { if (document.hidden) sendPicture(); });
get("save").addEventListener("click", sendPicture);
on("again", () => { sentDrawing = 0; });
