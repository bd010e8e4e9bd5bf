import assert from "node:assert/strict";
import { test } from "node:test";

import { expandCopies } from "tatu/net/model_copies";

const pose = [0, 0, 0, 0, 0, 0, 1];
const robot = [
  { id: 10, parent: 0, alias: "robot", pose, scripts: [{ id: 19, name: "a" }] },
  { id: 12, parent: 10, alias: "joint", pose },
  { id: 11, parent: 12, alias: "wheel", pose },
];
const moved = [1, 0, 0, 0, 0, 0, 1];

test("a copy has its own handles, parents, poses and scripts", () => {
  const copy = { copy_of: 10, alias: "other", ids: [20, 22, 21], poses: { 0: moved }, scripts: [{ id: 29, name: "b" }] };
  assert.deepEqual(expandCopies([{ id: 1, parent: 0, alias: "floor", pose }, ...robot, copy]).slice(4), [
    { id: 20, parent: 0, alias: "other", pose: moved, scripts: [{ id: 29, name: "b" }] },
    { id: 22, parent: 20, alias: "joint", pose },
    { id: 21, parent: 22, alias: "wheel", pose },
  ]);
});

test("the order of the objects stays that of the tree", () => {
  const copy = { copy_of: 10, alias: "robot", ids: [20, 22, 21], poses: {}, scripts: [{ id: 29, name: "a" }] };
  const objects = expandCopies([...robot, copy, { id: 30, parent: 0, alias: "wall", pose }]);
  assert.deepEqual(objects.map((o) => o.id), [10, 12, 11, 20, 22, 21, 30]);
});
