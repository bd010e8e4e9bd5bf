import assert from "node:assert/strict";
import { test } from "node:test";

import { equalize, layout, ticks } from "../lib/plot.js";
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

test("the scales of a map are equal where the curves are drawn", () => {
  const widthOf = (text) => 6 * text.length;
  for (const [x, y] of [[[0, 4], [1, 2]], [[0, 1], [-1000, 1000]], [[-0.001, 0.001], [0, 3]], [[5, 5.5], [-12345, -12344]]]) {
    const [timeRange, valueRange] = [x, y].map(([low, high]) => ({ low, high }));
    const { left, right, times, values, valueTicks, timeTicks } = layout(timeRange, valueRange, 420, 200, "m", true, widthOf);
    const horizontal = (420 - left - right) / (times.high - times.low);
    const vertical = (200 - 30) / (values.high - values.low);
    assert.ok(Math.abs(horizontal / vertical - 1) < 1e-9, `${horizontal} and ${vertical} pixels for a unit`);
    assert.ok(times.low <= x[0] + 1e-9 && times.high >= x[1] - 1e-9 && values.low <= y[0] + 1e-9 && values.high >= y[1] - 1e-9);
    for (const v of valueTicks.all) assert.ok(left >= 10 + widthOf(v.toFixed(valueTicks.digits)), `${v} at ${left}`);
    // The last number, at most at the end of the curves, leaves room for the unit.
    assert.ok(right >= 2 + widthOf("m") + widthOf(timeTicks.all.at(-1).toFixed(timeTicks.digits)) / 2, `${right}`);
  }
});
