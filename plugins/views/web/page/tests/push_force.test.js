import assert from "node:assert/strict";
import { test } from "node:test";

import { INITIAL_BOUND, MAX_BOUND, angleBetween, nextBound, springForce, tiltFactor, uprightTorque } from "../run/push_force.js";

/**
 * Simulates pulling a body along x towards `to`, m. The position and speed that determine the force are 0.1 s old;
 * `friction` is a deceleration, m/s^2.
 */
function drag({ mass, to, seconds, friction = 0 }) {
  const dt = 0.05;
  let [x, v, bound, farthest] = [0, 0, INITIAL_BOUND, 0];
  const seen = [[0, 0], [0, 0]];
  for (let t = 0; t < seconds; t += dt) {
    const [sx, sv] = seen.shift();
    const force = springForce([to - sx, 0, 0], [sv, 0, 0], mass, bound);
    bound = nextBound(bound, [to - sx, 0, 0], [sv, 0, 0], dt);
    const a = force[0] / mass;
    // Friction reduces the speed, at most to zero.
    v += a * dt;
    v -= Math.sign(v) * Math.min(Math.abs(v), friction * dt);
    x += v * dt;
    seen.push([x, v]);
    farthest = Math.max(farthest, x);
  }
  return { x, v, bound, farthest };
}

test("a body comes to the pointer and stays there, whatever its mass", () => {
  for (const mass of [0.1, 20]) {
    const { x, v, farthest } = drag({ mass, to: 1, seconds: 6 });
    assert.ok(Math.abs(x - 1) < 0.01 && Math.abs(v) < 0.01, `${x} ${v}`);
    assert.ok(farthest < 1.15, `${farthest}`);
  }
});

test("the force is bounded by the mass", () => {
  const force = springForce([100, 0, 100], [0, 0, 0], 2, INITIAL_BOUND);
  assert.ok(Math.abs(Math.hypot(...force) - 2 * INITIAL_BOUND) < 1e-9);
  assert.ok(Math.abs(force[0] - force[2]) < 1e-9);
});

test("what friction holds is moved after a while, and lifting is possible", () => {
  assert.ok(drag({ mass: 5, to: 2, seconds: 0.3, friction: 9 }).x < 0.01);
  assert.ok(drag({ mass: 5, to: 2, seconds: 4, friction: 9 }).x > 0.3);
  assert.ok(MAX_BOUND > 9.81);
});

test("the bound grows for what rests away from the pointer only", () => {
  assert.ok(drag({ mass: 5, to: 1, seconds: 5 }).bound < INITIAL_BOUND + 2);
  assert.equal(nextBound(INITIAL_BOUND, [1, 0, 0], [0.5, 0, 0], 0.1), INITIAL_BOUND);
  assert.equal(nextBound(INITIAL_BOUND, [0.01, 0, 0], [0, 0, 0], 0.1), INITIAL_BOUND);
  assert.equal(nextBound(MAX_BOUND, [1, 0, 0], [0, 0, 0], 0.1), MAX_BOUND);
});

test("a force turns about the vertical only", () => {
  assert.deepEqual(uprightTorque([0.2, 0, 0.5], [0, 10, 3]), [0, 0, 2]);
});

test("what tilts is pulled less, and not at all before it falls", () => {
  assert.deepEqual([0, 2, 4, 6, 90].map(tiltFactor), [1, 1, 0.5, 0, 0]);
  assert.ok(Math.abs(angleBetween([0, 0, 1], [0, Math.sin(0.1), Math.cos(0.1)]) - 0.1 * 180 / Math.PI) < 1e-9);
  assert.equal(angleBetween([0, 0, 1], [0, 0, -1]), 180);
});
