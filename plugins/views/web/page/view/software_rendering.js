// @ts-check
// Simplified images for software rendering of large scenes: they have a lower resolution, and are not antialiased.

import * as THREE from "three";

/** Number of triangles above which a scene is large for software rendering. */
const LARGE_SCENE_TRIANGLES = 30_000;
/** Ratio of the width and height of simplified images to those of the view. */
const RESOLUTION_FACTOR = 0.6;

/**
 * Returns whether the browser renders in software, not on a graphics processor.
 * @param {THREE.WebGLRenderer} renderer
 */
export function isSoftware(renderer) {
  const gl = renderer.getContext();
  const extension = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(gl.getParameter(extension ? extension.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

const target = new THREE.WebGLRenderTarget(1, 1);
target.texture.colorSpace = THREE.SRGBColorSpace;
const stage = new THREE.Scene();
const screen = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), new THREE.MeshBasicMaterial({ map: target.texture, depthTest: false, depthWrite: false }));
stage.add(screen);
const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -1, 1);

/**
 * Draws a simplified image. Returns the number of rendered triangles.
 * @param {THREE.WebGLRenderer} renderer
 * @param {THREE.Scene} scene
 * @param {THREE.Camera} from
 */
export function drawSimplified(renderer, scene, from) {
  const { width, height } = renderer.domElement;
  const [w, h] = [Math.ceil(RESOLUTION_FACTOR * width), Math.ceil(RESOLUTION_FACTOR * height)];
  if (target.width !== w || target.height !== h) target.setSize(w, h);
  renderer.setRenderTarget(target);
  renderer.render(scene, from);
  const { triangles } = renderer.info.render;
  renderer.setRenderTarget(null);
  renderer.render(stage, camera);
  return triangles;
}

/** Returns whether a scene is large for software rendering. @param {number} triangles of the last image */
export function isLargeForSoftware(triangles) {
  return triangles > LARGE_SCENE_TRIANGLES;
}
