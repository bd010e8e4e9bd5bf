import assert from "node:assert/strict";
import { test } from "node:test";

import { evaluate } from "../lib/expressions.js";

/** Checks a value up to rounding. */
function near(found, expected) {
  assert.ok(Math.abs(found - expected) <= 1e-12 * Math.max(1, Math.abs(expected)), `${found} instead of ${expected}`);
}

test("numbers, operators and parentheses", () => {
  const all = [
    ["2*3", 6], ["1 + 2 * 3", 7], ["(1 + 2) * 3", 9], ["-2 - -3", 1], ["1/4", 0.25], ["8/2/2", 2], ["1,5", 1.5], [" .5 ", 0.5], ["1e-3", 0.001], ["2\u00b73", 6],
    ["2*pi", 2 * Math.PI], ["\u22121", -1], ["2 - 1e2", -98],
  ];
  for (const [text, expected] of all) near(evaluate(text, ""), expected);
  assert.equal(evaluate("-inf", "m"), -Infinity);
});

test("units are converted to that of the field", () => {
  const all = [
    ["10 cm", "m", 0.1], ["10cm + 5 mm", "m", 0.105], ["2*3 cm", "m", 0.06], ["(1 + 1) cm", "m", 0.02], ["1 m/4", "m", 0.25], ["45 deg", "\u00b0", 45],
    ["pi rad", "\u00b0", 180], ["90\u00b0", "\u00b0", 90], ["36 km/h", "m/s", 10], ["1 rad/s", "\u00b0/s", 180 / Math.PI], ["10 rpm", "\u00b0/s", 60],
    ["200 g", "kg", 0.2], ["20 ms", "s", 0.02], ["30 mN m", "N m", 0.03], ["5 Nm", "N m", 5],
  ];
  for (const [text, unit, expected] of all) near(evaluate(text, unit), expected);
});

test("what is no quantity is refused, with the reason", () => {
  for (const text of ["", " ", "abc", "1.2.3", "1,2,3", "2*", "(2", "2)", "2 3", "0/0", "1" + "+1".repeat(200), "(".repeat(150)]) {
    assert.throws(() => evaluate(text, "m"), ({ error }) => /expected a number in m|is not a unit/.test(error), text);
  }
  assert.throws(() => evaluate("2 kg", "m"), { error: '"kg" is not a unit of this value, which is in m' });
  assert.throws(() => evaluate("2 m", ""), { error: '"m" is not a unit of this value, which has none' });
});
