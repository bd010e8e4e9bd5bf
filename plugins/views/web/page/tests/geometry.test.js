import assert from "node:assert/strict";
import { test } from "node:test";

import { fan, fromDegrees, snap, toDegrees } from "../geometry.js";

function near(got, wanted, within = 1e-9) {
  assert.equal(got.length, wanted.length);
  got.forEach((x, i) => assert.ok(Math.abs(x - wanted[i]) <= within, `[${got}] is not [${wanted}]`));
}

/** The product of two turns, the second of them first. */
function times([x, y, z, w], [a, b, c, d]) {
  return [w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c];
}

test("snapping", () => {
  assert.equal(snap(0.26, 0.1), 0.3);
  assert.equal(snap(-0.26, 0.1), -0.3);
  assert.equal(snap(44, 15), 45);
  assert.equal(snap(0.123, 0), 0.123);
  assert.ok(Object.is(snap(-0.01, 0.1), 0), "no negative zero");
});

test("turns about one axis", () => {
  const half = Math.SQRT1_2;
  near(toDegrees([half, 0, 0, half]), [90, 0, 0]);
  near(toDegrees([0, Math.sin(Math.PI / 12), 0, Math.cos(Math.PI / 12)]), [0, 30, 0]);
  near(toDegrees([0, 0, half, half]), [0, 0, 90]);
  near(toDegrees([0, 0, 0, 2]), [0, 0, 0]);
  near(toDegrees([0, 0, 0, 0]), [0, 0, 0]);
});

test("angles are those of Rx Ry Rz", () => {
  const about = (axis, degrees) => {
    const q = [0, 0, 0, Math.cos(degrees * Math.PI / 360)];
    q[axis] = Math.sin(degrees * Math.PI / 360);
    return q;
  };
  near(fromDegrees([20, -35, 110]), times(times(about(0, 20), about(1, -35)), about(2, 110)));
});

test("there and back", () => {
  for (const angles of [[10, 20, 30], [-170, 80, 5], [0, -89, 179], [180, 0, -90], [45, 89.9, 45]]) {
    near(toDegrees(fromDegrees(angles)), angles, 1e-6);
  }
});

test("where two axes coincide, the turn stays the same", () => {
  for (const angles of [[30, 90, 40], [30, -90, 40], [-170, 90, -100]]) {
    const q = fromDegrees(angles);
    const [x, y, z] = toDegrees(q);
    assert.equal(Math.abs(y), 90);
    assert.equal(x, 0);
    const again = fromDegrees([x, y, z]);
    const dot = q.reduce((sum, c, i) => sum + c * again[i], 0);
    assert.ok(Math.abs(dot) > 1 - 1e-9, `${angles} became ${[x, y, z]}`);
  }
});

test("a scan in one plane is one fan", () => {
  const { points, index } = fan({ distance: [1, 2, 3], angle: [-Math.PI / 2, 0, Math.PI / 2], range: 5 });
  near(points, [0, 0, 0, -1, 0, 0, 0, 0, 2, 3, 0, 0]);
  assert.deepEqual(index, [0, 1, 2, 0, 2, 3]);
});

test("a beam that meets nothing reaches to the range", () => {
  near(fan({ distance: [1, null], angle: [0, Math.PI / 2], range: 5 }).points.slice(6), [5, 0, 0]);
  near(fan({ distance: [1, null], angle: [0, Math.PI / 2] }).points.slice(6), [1, 0, 0]);
  near(fan({ distance: [null], angle: [0] }).points.slice(3), [0, 0, 10]);
});

test("layers are raised by their elevation, and not joined", () => {
  const up = Math.PI / 6;
  const { points, index } = fan({ distance: [2, 2, 2, 2], angle: [-0.1, 0.1, -0.1, 0.1], elevation: [0, 0, up, up], range: 5 });
  assert.deepEqual(index, [0, 1, 2, 0, 3, 4]);
  near(points.slice(9, 12), [-2 * Math.sin(0.1) * Math.cos(up), 1, 2 * Math.cos(0.1) * Math.cos(up)]);
});
