import assert from "node:assert/strict";
import { test } from "node:test";

import { BINARY, eachEntry, parseImage, parseMesh, timeOf } from "../net/binary_messages.js";

/** Builds a frame. Each entry is a function that writes the entry at an offset and returns the offset of its end. */
function frame(time, ...entries) {
  const view = new DataView(new ArrayBuffer(1024));
  view.setUint8(0, 1);
  view.setFloat64(8, time, true);
  view.setUint32(16, entries.length, true);
  let at = 20;
  for (const write of entries) at = write(view, at);
  return new DataView(view.buffer.slice(0, at));
}

function entry(kind, id, ...numbers) {
  return (view, at) => {
    view.setUint32(at, id | (kind << 24), true);
    at += 4;
    for (const [size, x] of numbers) {
      if (size === 2) view.setInt16(at, x, true);
      else if (size === 4) view.setInt32(at, x, true);
      else if (size === "f32") view.setFloat32(at, x, true);
      else view.setFloat64(at, x, true);
      at += size === "f32" ? 4 : size;
    }
    return at;
  };
}

function read(view) {
  const all = [];
  eachEntry(view, (id, what, numbers) => all.push({ id, what, numbers: [...numbers] }));
  return all;
}

test("kinds of messages", () => {
  assert.deepEqual([1, 2, 3, 4, 5].map((k) => BINARY[k]), ["frame", "mesh", "image", "texture", undefined]);
});

test("a frame of the live page: units of 0.1 mm and 1/32767", () => {
  const view = frame(
    1.25,
    entry(0, 7, [4, 10000], [4, -25], [4, 0], [2, 0], [2, 0], [2, 0], [2, 32767]),
    entry(1, 0xabcdef, ["f32", 0.5]),
    entry(2, 9, [2, 32767], [2, 0], [2, 0], [2, 0]),
  );
  assert.equal(timeOf(view), 1.25);
  assert.deepEqual(read(view), [
    { id: 7, what: "pose", numbers: [1, -0.0025, 0, 0, 0, 0, 1] },
    { id: 0xabcdef, what: "position", numbers: [0.5] },
    { id: 9, what: "rotation", numbers: [1, 0, 0, 0] },
  ]);
});

test("a frame of a film is exact", () => {
  const third = 1 / 3;
  const view = frame(0, entry(3, 1, ...[third, 2, 3, 0, 0, 0, 1].map((x) => [8, x])), entry(4, 2, [8, third]), entry(5, 3, ...[0, third, 0, 1].map((x) => [8, x])));
  assert.deepEqual(read(view).map((e) => e.numbers), [[third, 2, 3, 0, 0, 0, 1], [third], [0, third, 0, 1]]);
});

test("a frame that ends early or has an unknown entry is read as far as it goes", () => {
  const whole = frame(0, entry(1, 1, ["f32", 1]), entry(1, 2, ["f32", 2]));
  assert.equal(read(new DataView(whole.buffer.slice(0, whole.byteLength - 1))).length, 1);
  assert.equal(read(frame(0, entry(1, 1, ["f32", 1]), entry(99, 2), entry(1, 3, ["f32", 3]))).length, 1);
});

test("a mesh with places in an image", () => {
  const view = new DataView(new ArrayBuffer(28 + 36 + 12 + 24));
  view.setUint32(20, 3, true);
  view.setUint32(24, 1, true);
  for (let i = 0; i < 6; i++) view.setFloat32(76 + 4 * i, i / 4, true);
  assert.deepEqual([...(parseMesh(view).coordinates ?? [])], [0, 0.25, 0.5, 0.75, 1, 1.25]);
});

test("a mesh", () => {
  const view = new DataView(new ArrayBuffer(28 + 36 + 12));
  view.setUint8(0, 2);
  [..."0123456789abcdef"].forEach((c, i) => view.setUint8(4 + i, c.charCodeAt(0)));
  view.setUint32(20, 3, true);
  view.setUint32(24, 1, true);
  for (let i = 0; i < 9; i++) view.setFloat32(28 + 4 * i, i / 2, true);
  [0, 2, 1].forEach((n, i) => view.setUint32(64 + 4 * i, n, true));
  const read = parseMesh(view);
  assert.equal(read.hash, "0123456789abcdef");
  assert.deepEqual([...read.points], [0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4]);
  assert.deepEqual([...read.triangles], [0, 2, 1]);
});

/** Parses an image of one column and two rows; `write` writes its pixels. */
function picture(depth, write) {
  const view = new DataView(new ArrayBuffer(16 + (depth ? 8 : 6)));
  view.setUint8(0, 3);
  view.setUint8(2, depth ? 1 : 0);
  view.setUint32(4, 42, true);
  view.setUint32(8, 1, true);
  view.setUint32(12, 2, true);
  write(view);
  return parseImage(view);
}

test("a color image: the lowest row comes first, and is shown last", () => {
  const { id, width, height, pixels } = picture(false, (view) => [1, 2, 3, 4, 5, 6].forEach((x, i) => view.setUint8(16 + i, x)));
  assert.deepEqual([id, width, height], [42, 1, 2]);
  assert.deepEqual([...pixels], [4, 5, 6, 255, 1, 2, 3, 255]);
});

test("a depth image: near is light, far and nothing are dark", () => {
  const { pixels } = picture(true, (view) => { view.setFloat32(16, 4, true); view.setFloat32(20, 1, true); });
  assert.deepEqual([...pixels], [191, 191, 191, 255, 0, 0, 0, 255]);
  const free = picture(true, (view) => { view.setFloat32(16, Infinity, true); view.setFloat32(20, 2, true); });
  assert.deepEqual([...free.pixels], [0, 0, 0, 255, 0, 0, 0, 255]);
  const view = new DataView(new ArrayBuffer(32));
  [[2, 1], [8, 1], [12, 2]].forEach(([at, x]) => (at === 2 ? view.setUint8(at, x) : view.setUint32(at, x, true)));
  [1, 2, 1, 3].forEach((x, i) => view.setFloat32(16 + 4 * i, x, true));
  const planes = parseImage(view);
  assert.deepEqual([planes.isDepth, planes.near, planes.far], [true, 1, 3]);
  assert.deepEqual([...planes.pixels], [128, 128, 128, 255, 255, 255, 255, 255]);
});
