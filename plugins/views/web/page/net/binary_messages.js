// @ts-check
// Parses binary messages: frames, meshes, images and textures, as described in docs/reference/web-stream.md. This
// module does not access the DOM, so it can be tested without a browser.

/** Kinds of binary messages, by their first byte. @type {{ [kind: number]: "frame" | "mesh" | "image" | "texture" | undefined }} */
export const BINARY = { 1: "frame", 2: "mesh", 3: "image", 4: "texture" };
/** Size of the header of a frame, bytes. */
const FRAME_HEADER_BYTES = 20;

/**
 * An entry of a frame: the handle of an object, and its pose, joint position or joint rotation.
 * @typedef {{ id: number, what: "pose" | "position" | "rotation", numbers: number[] }} Entry
 */

/**
 * Reads a value in full precision.
 * @param {DataView} view
 * @param {number} offset
 */
const float64 = (view, offset) => view.getFloat64(offset, true);
/**
 * Reads a component of a quaternion.
 * @param {DataView} view
 * @param {number} offset
 */
const readUnit = (view, offset) => view.getInt16(offset, true) / 32767;
/**
 * Reads a coordinate, m.
 * @param {DataView} view
 * @param {number} offset
 */
const readLength = (view, offset) => view.getInt32(offset, true) / 1e4;

/**
 * The types of entries: what they contain, and how each value is read and its size in bytes.
 * @type {{ what: Entry["what"], read: ((view: DataView, at: number) => number)[], size: number[] }[]}
 */
const ENTRIES = [
  { what: "pose", read: [readLength, readLength, readLength, readUnit, readUnit, readUnit, readUnit], size: [4, 4, 4, 2, 2, 2, 2] },
  { what: "position", read: [(view, offset) => view.getFloat32(offset, true)], size: [4] },
  { what: "rotation", read: [readUnit, readUnit, readUnit, readUnit], size: [2, 2, 2, 2] },
  // The same three types in full precision, for films.
  { what: "pose", read: Array(7).fill(float64), size: Array(7).fill(8) },
  { what: "position", read: [float64], size: [8] },
  { what: "rotation", read: Array(4).fill(float64), size: Array(4).fill(8) },
];

/**
 * Returns the size of an entry without its key, bytes; 0 for unknown types.
 * @param {number} kind type of the entry
 */
export function entryLength(kind) {
  return ENTRIES[kind]?.size.reduce((sum, n) => sum + n, 0) ?? 0;
}

/**
 * Returns whether anything has moved since the last frame.
 * @param {DataView} view
 */
export function hasMotion(view) {
  return view.getUint32(16, true) > 0;
}

/**
 * Returns the simulation time of a frame, s.
 * @param {DataView} view
 */
export function timeOf(view) {
  return view.getFloat64(8, true);
}

/**
 * Calls `f` with each entry of a frame. The array is reused for the next entry. A frame that is truncated or contains
 * an entry of an unknown type is read up to that point.
 * @param {DataView} view
 * @param {(id: number, what: Entry["what"], numbers: number[]) => void} f
 */
export function eachEntry(view, f) {
  const count = view.getUint32(16, true);
  const numbers = [0, 0, 0, 0, 0, 0, 0];
  let offset = FRAME_HEADER_BYTES;
  for (let i = 0; i < count && offset + 4 <= view.byteLength; i++) {
    const key = view.getUint32(offset, true);
    const entry = ENTRIES[key >>> 24];
    offset += 4;
    if (!entry || offset + entryLength(key >>> 24) > view.byteLength) return;
    numbers.length = entry.read.length;
    entry.read.forEach((read, k) => {
      numbers[k] = read(view, offset);
      offset += entry.size[k] ?? 0;
    });
    f(key & 0xffffff, entry.what, numbers);
  }
}

/**
 * Parses a mesh: its hash, the coordinates of its points, the point indices of its triangles, and the texture
 * coordinates of its points, if it has them.
 * @param {DataView} view
 * @returns {{ hash: string, points: Float32Array, triangles: Uint32Array, coordinates: Float32Array | null }}
 */
export function parseMesh(view) {
  const { buffer, byteOffset } = view;
  const hash = new TextDecoder().decode(new Uint8Array(buffer, byteOffset + 4, 16));
  const [points, triangles] = [view.getUint32(20, true), view.getUint32(24, true)];
  const from = byteOffset + 28;
  const end = from + 12 * points + 12 * triangles;
  const hasCoordinates = view.byteLength - (end - byteOffset) >= 8 * points;
  return {
    hash,
    points: new Float32Array(buffer.slice(from, from + 12 * points)),
    triangles: new Uint32Array(buffer.slice(from + 12 * points, end)),
    coordinates: hasCoordinates && points > 0 ? new Float32Array(buffer.slice(end, end + 8 * points)) : null,
  };
}

/**
 * Parses a texture: its hash, its size in pixels, and its pixels as RGBA bytes, the top row first.
 * @param {DataView} view
 * @returns {{ hash: string, width: number, height: number, pixels: Uint8Array<ArrayBuffer> }}
 */
export function parseTexture(view) {
  const { buffer, byteOffset } = view;
  const hash = new TextDecoder().decode(new Uint8Array(buffer, byteOffset + 4, 16));
  const [width, height] = [view.getUint32(20, true), view.getUint32(24, true)];
  const from = byteOffset + 28;
  return { hash, width, height, pixels: new Uint8Array(/** @type {ArrayBuffer} */ (buffer).slice(from, from + 4 * width * height)) };
}

/**
 * Parses an image of a sensor, and converts it to RGBA bytes, the top row first. Smaller depths are lighter: `near` and
 * `far`, m, are white and black. They are the planes of the sensor, or 0 and the largest depth if it has none, and 0 for
 * colors.
 * @param {DataView} view
 * @returns {{ id: number, isDepth: boolean, near: number, far: number, width: number, height: number, pixels: Uint8ClampedArray<ArrayBuffer> }}
 */
export function parseImage(view) {
  const [id, width, height] = [view.getUint32(4, true), view.getUint32(8, true), view.getUint32(12, true)];
  const pixels = new Uint8ClampedArray(4 * width * height);
  const color = view.getUint8(2) === 0;
  const depth = (/** @type {number} */ i) => view.getFloat32(16 + 4 * i, true);
  let [near, far] = [0, 0];
  const count = width * height;
  if (!color && view.byteLength >= 16 + 4 * (count + 2)) [near, far] = [depth(count), depth(count + 1)];
  else if (!color) for (let i = 0; i < count; i++) if (Number.isFinite(depth(i))) far = Math.max(far, depth(i));
  // Pixels without a hit are black, like those with the largest depth.
  const light = (/** @type {number} */ i) => (Number.isFinite(depth(i)) ? 255 * (1 - (depth(i) - near) / (far - near || 1)) : 0);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const from = y * width + x;
      const to = 4 * ((height - 1 - y) * width + x);
      for (let c = 0; c < 3; c++) pixels[to + c] = color ? view.getUint8(16 + 3 * from + c) : light(from);
      pixels[to + 3] = 255;
    }
  }
  return { id, isDepth: !color, near, far, width, height, pixels };
}
