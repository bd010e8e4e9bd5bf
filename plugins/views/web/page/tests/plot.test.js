import assert from "node:assert/strict";
import { test } from "node:test";

import { equalize, ticks } from "../lib/plot.js";
import { csv, csvOfPairs } from "../lib/csv.js";

test("axes have round numbers, and not too many", () => {
  assert.deepEqual(ticks(0, 10, 5), { all: [0, 2, 4, 6, 8, 10], digits: 0 });
  assert.deepEqual(ticks(0.13, 0.62, 5).all.map((x) => +x.toFixed(9)), [0.2, 0.3, 0.4, 0.5, 0.6]);
  assert.equal(ticks(0.13, 0.62, 5).digits, 1);
  for (const [low, high, most] of [[-1e-9, 1e-9, 4], [-3, 1e6, 7], [5, 5.0001, 3], [1e15, 1.1e15, 6]]) {
    const { all } = ticks(low, high, most);
    assert.ok(all.length <= most + 1 && all.length >= 1, `${low} to ${high}: ${all}`);
    assert.ok(all.every((t) => t >= low - 1e-9 * Math.abs(low) && t <= high * (1 + 1e-9)), `${all}`);
  }
});

test("curves become a table with a row for each time", () => {
  const a = { name: "x", unit: "m", times: [0, 0.1, 0.3], values: [1, 2, null] };
  const b = { name: 'a "b", c', times: [0.1, 0.2], values: [5, 6] };
  assert.equal(csv([a, b], "time (s)"), 'time (s),x (m),"a ""b"", c"\n0,1,\n0.1,2,5\n0.2,,6\n0.3,,\n');
  assert.equal(csvOfPairs([a], "y"), "y,x (m)\n0,1\n0.1,2\n0.3,\n");
});

test("a unit has the same length on both axes of a map", () => {
  const [x, y] = [{ low: 0, high: 4 }, { low: 1, high: 2 }];
  equalize(x, 400, y, 200);
  assert.deepEqual([x, y], [{ low: 0, high: 4 }, { low: 0.5, high: 2.5 }]);
});
