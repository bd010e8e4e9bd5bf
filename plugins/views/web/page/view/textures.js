// @ts-check
// Projects texture images onto parts as the simulation does, by computing the texture coordinates of each vertex.

import * as THREE from "three";
import { parseTexture } from "tatu/net/binary_messages";
import { on } from "tatu/net/connection";
import { opacityParameters, sceneMaterial } from "tatu/view/light";

/** @import { Texture, VisiblePart } from "tatu/protocol" */

/** @type {Map<string, { width: number, height: number, pixels: Uint8Array<ArrayBuffer> }>} */
const images = new Map();
/** @type {Map<string, THREE.MeshLambertMaterial>} */
const materials = new Map();

on("texture", (view) => {
  const { hash, ...image } = parseTexture(view);
  images.set(hash, image);
});

/**
 * Returns the material for a texture on a part, or undefined if the image has not arrived. Unless the
 * blend mode is `modulate`, the image and the color are blended in advance.
 * @param {Texture} texture
 * @param {VisiblePart} part
 */
function material(texture, { color, opacity = 1, form }) {
  const { image, blend, repeat, smooth } = texture;
  const closed = form !== "mesh" && form !== "plane";
  const key = [image, blend, repeat.join(), smooth, [...color, opacity].map((x) => x.toFixed(3)).join(), closed].join(" ");
  const existing = materials.get(key);
  const source = images.get(image);
  if (existing || !source) return existing;
  const { width, height, pixels } = source;
  let mixed = pixels;
  if (blend !== "modulate") {
    mixed = new Uint8Array(pixels.length);
    for (let i = 0; i < pixels.length; i++) {
      const [base, texel] = [255 * (color[i % 4] ?? 1), pixels[i] ?? 0];
      const opacity = (pixels[i - (i % 4) + 3] ?? 255) / 255;
      mixed[i] = i % 4 === 3 ? 255 : blend === "add" ? Math.min(255, base + texel) : base + (texel - base) * opacity;
    }
  }
  const map = new THREE.DataTexture(mixed, width, height);
  map.colorSpace = THREE.SRGBColorSpace;
  const wrap = (/** @type {boolean} */ repeats) => repeats ? THREE.RepeatWrapping : THREE.ClampToEdgeWrapping;
  map.wrapS = wrap(repeat[0]);
  map.wrapT = wrap(repeat[1]);
  map.magFilter = smooth ? THREE.LinearFilter : THREE.NearestFilter;
  map.minFilter = smooth ? THREE.LinearMipmapLinearFilter : THREE.NearestMipmapLinearFilter;
  map.generateMipmaps = true;
  map.anisotropy = 4;
  map.needsUpdate = true;
  const base = new THREE.Color(1, 1, 1);
  if (blend === "modulate") base.setRGB(...color, THREE.SRGBColorSpace);
  const created = sceneMaterial({ color: base, map, ...opacityParameters(opacity, closed) });
  materials.set(key, created);
  return created;
}

/**
 * Returns the texture coordinates of a point, which increase to the right and upwards; the image covers 0 to 1.
 * @param {Texture} texture
 * @param {THREE.Vector3} p in the frame of the projection
 * @param {THREE.Vector3} n the surface normal at the point
 * @returns {[number, number]}
 */
export function textureCoordinates({ mapping, size }, p, n) {
  const turn = 2 * Math.PI;
  let [right, up] = [p.x, p.y];
  if (mapping === "cylinder") [right, up] = [Math.atan2(p.y, p.x) / turn, p.z];
  else if (mapping === "sphere") [right, up] = [Math.atan2(p.y, p.x) / turn, Math.atan2(p.z, Math.hypot(p.x, p.y)) / Math.PI];
  else if (mapping === "box") {
    const [x, y, z] = [Math.abs(n.x), Math.abs(n.y), Math.abs(n.z)];
    if (z >= x && z >= y) [right, up] = [p.x, p.y];
    else [right, up] = y >= x ? [p.x, p.z] : [p.y, p.z];
  }
  return [right / size[0] + 0.5, up / size[1] + 0.5];
}

/**
 * Returns the geometry and material of a textured form, or null if the image has not arrived or if the form does not
 * have the required texture coordinates.
 * @param {Texture} texture
 * @param {VisiblePart} part
 * @param {THREE.BufferGeometry} form
 * @param {THREE.Vector3} scale factor by which the form is scaled when it is drawn
 */
export function applyTexture(texture, part, form, scale) {
  const textured = material(texture, part);
  if (!textured) return null;
  // A mesh without texture coordinates is drawn without the texture.
  if (texture.mapping === "mesh" && !form.getAttribute("uv")) return null;
  const geometry = form.index ? form.toNonIndexed() : form.clone();
  if (texture.mapping === "mesh") {
    const meshCoordinates = geometry.getAttribute("uv");
    const [width, height] = texture.size;
    const scaled = new Float32Array(2 * meshCoordinates.count);
    // The vertical coordinate is inverted, because image rows are stored from top to bottom.
    for (let i = 0; i < meshCoordinates.count; i++) scaled.set([meshCoordinates.getX(i) / width, 1 - meshCoordinates.getY(i) / height], 2 * i);
    geometry.setAttribute("uv", new THREE.BufferAttribute(scaled, 2));
    return { geometry, material: textured };
  }
  const [points, normals] = [geometry.getAttribute("position"), geometry.getAttribute("normal")];
  const { size, pose } = texture;
  const inverse = new THREE.Quaternion().fromArray(pose, 3).invert();
  const origin = new THREE.Vector3().fromArray(pose);
  const [a, b, c] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  const n = new THREE.Vector3();
  const coordinates = new Float32Array(2 * points.count);
  for (let i = 0; i < points.count; i += 3) {
    [a, b, c].forEach((p, k) => p.fromBufferAttribute(points, i + k).multiply(scale).sub(origin).applyQuaternion(inverse));
    // The normal of the triangle is used, so that all its corners are projected from the same side of the box.
    n.copy(b).sub(a).cross(c.clone().sub(a));
    if (n.lengthSq() === 0) n.fromBufferAttribute(normals, i).applyQuaternion(inverse);
    const corners = [a, b, c].map((p) => textureCoordinates(texture, p, n));
    const [first = 0] = corners[0] ?? [];
    corners.forEach(([right, up], k) => {
      // For a triangle across the seam, all corners are moved to the side of the first one.
      const period = texture.mapping === "cylinder" || texture.mapping === "sphere" ? 1 / size[0] : 0;
      const unwrapped = period ? right - period * Math.round((right - first) / period) : right;
      // The vertical coordinate is inverted, because image rows are stored from top to bottom.
      coordinates.set([unwrapped, 1 - up], 2 * (i + k));
    });
  }
  geometry.setAttribute("uv", new THREE.BufferAttribute(coordinates, 2));
  return { geometry, material: textured };
}
