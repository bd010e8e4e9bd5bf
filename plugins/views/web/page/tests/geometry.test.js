import assert from "node:assert/strict";
import { test } from "node:test";

import { principal } from "../lib/inertia.js";
import { roundToStep } from "../lib/numbers.js";
import { IDENTITY, compose, frameOf, inverse, movedPose, positionOf, rotationAbout, rotationOf, translationAlong } from "../lib/poses.js";
import { axisRotation, conjugate, fromDegrees, multiply, rotate, screenAxes, toDegrees } from "../lib/rotations.js";
import { scanSurface } from "../view/scan_surface.js";

function near(got, wanted, within = 1e-9) {
  assert.equal(got.length, wanted.length);
  got.forEach((x, i) => assert.ok(Math.abs(x - wanted[i]) <= within, `[${got}] is not [${wanted}]`));
}

/** Returns the product of two rotations; the second one is applied first. */
function times([x, y, z, w], [a, b, c, d]) {
  return [w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c];
}

test("snapping", () => {
  assert.equal(roundToStep(0.26, 0.1), 0.3);
  assert.equal(roundToStep(-0.26, 0.1), -0.3);
  assert.equal(roundToStep(44, 15), 45);
  assert.equal(roundToStep(0.123, 0), 0.123);
  assert.ok(Object.is(roundToStep(-0.01, 0.1), 0), "no negative zero");
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
  near(fromDegrees([20, -35, 110]), times(times(axisRotation(0, 20), axisRotation(1, -35)), axisRotation(2, 110)));
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
  const { points, index } = scanSurface({ distance: [1, 2, 3], angle: [-Math.PI / 2, 0, Math.PI / 2], range: 5 });
  near(points, [0, 0, 0, -1, 0, 0, 0, 0, 2, 3, 0, 0]);
  assert.deepEqual(index, [0, 1, 2, 0, 2, 3]);
});

test("a beam that meets nothing reaches to the range", () => {
  near(scanSurface({ distance: [1, null], angle: [0, Math.PI / 2], range: 5 }).points.slice(6), [5, 0, 0]);
  near(scanSurface({ distance: [1, null], angle: [0, Math.PI / 2] }).points.slice(6), [1, 0, 0]);
  near(scanSurface({ distance: [null], angle: [0] }).points.slice(3), [0, 0, 10]);
});

test("layers are raised by their elevation, and not joined", () => {
  const up = Math.PI / 6;
  const { points, index } = scanSurface({ distance: [2, 2, 2, 2], angle: [-0.1, 0.1, -0.1, 0.1], elevation: [0, 0, up, up], range: 5 });
  assert.deepEqual(index, [0, 1, 2, 0, 3, 4]);
  near(points.slice(9, 12), [-2 * Math.sin(0.1) * Math.cos(up), 1, 2 * Math.cos(0.1) * Math.cos(up)]);
});

/** Poses of a translated and rotated parent in the world frame, and of an object in the frame of this parent. */
const PARENT = [1, 2, 3, ...fromDegrees([10, 20, 90])];
const LOCAL = [0.5, 0, 0.25, ...fromDegrees([0, 0, 30])];
const OF = { world: compose(PARENT, LOCAL), local: LOCAL };

test("rotations and poses", () => {
  near(rotate(axisRotation(2, 90), [1, 0, 0]), [0, 1, 0]);
  near(rotate(axisRotation(0, 90), [0, 1, 0]), [0, 0, 1]);
  const q = fromDegrees([20, -35, 110]);
  near(multiply(q, conjugate(q)), [0, 0, 0, 1]);
  near(compose(PARENT, inverse(PARENT)), IDENTITY);
  near(compose([1, 0, 0, ...axisRotation(2, 90)], [1, 0, 0, 0, 0, 0, 1]), [1, 1, 0, ...axisRotation(2, 90)]);
});

test("frames of an object", () => {
  near(frameOf("world", OF), IDENTITY);
  near(frameOf("parent", OF), PARENT);
  near(frameOf("own", OF), OF.world);
});

test("a shift is along the axes of its frame", () => {
  for (const [frame, wanted] of [["world", [0.1, 0, 0]], ["parent", rotate(rotationOf(PARENT), [0.1, 0, 0])]]) {
    const after = movedPose(translationAlong(frameOf(frame, OF), [0.1, 0, 0]), OF);
    near(compose(PARENT, after), [...positionOf(OF.world).map((x, i) => x + wanted[i]), ...rotationOf(OF.world)], 1e-9);
  }
  near(movedPose(translationAlong(frameOf("parent", OF), [0.1, 0, 0]), OF), [0.6, 0, 0.25, ...rotationOf(LOCAL)]);
});

test("what is not shifted keeps its digits", () => {
  const of = { world: [0.1, 0.2, 0.3, 0, 0, 0, 1], local: [0.1, 0.2, 0.3, 0, 0, 0, 1] };
  assert.deepEqual(movedPose(translationAlong(IDENTITY, [0.5, 0, 0]), of), [0.6, 0.2, 0.3, 0, 0, 0, 1]);
});

test("a turn about a point", () => {
  near(movedPose(rotationAbout(IDENTITY, axisRotation(2, 90), [1, 0, 0]), { world: [2, 0, 0, 0, 0, 0, 1], local: [2, 0, 0, 0, 0, 0, 1] }), [1, 1, 0, ...axisRotation(2, 90)]);
  // A rotation about the object itself, in the frame of its parent: the position remains, the orientation changes.
  const after = movedPose(rotationAbout(frameOf("parent", OF), axisRotation(2, 15), positionOf(OF.world)), OF);
  near(positionOf(after), positionOf(LOCAL));
  near(toDegrees(rotationOf(after)), [0, 0, 45]);
});

test("arrow keys go along the axes nearest to the screen's", () => {
  // From the front, x points right and y away; from the side, y points right and x towards the camera.
  assert.deepEqual(screenAxes([0, 0, 0, 1], [1, 0, 0], [0, 0.8, 0.6]), { across: { axis: 0, sign: 1 }, ahead: { axis: 1, sign: 1 } });
  assert.deepEqual(screenAxes([0, 0, 0, 1], [0.1, 0.9, 0], [-0.9, 0.1, 0.5]), { across: { axis: 1, sign: 1 }, ahead: { axis: 0, sign: -1 } });
  // A frame that is rotated by 90 degrees.
  assert.deepEqual(screenAxes(axisRotation(2, 90), [1, 0, 0], [0, 1, 0]), { across: { axis: 1, sign: -1 }, ahead: { axis: 0, sign: 1 } });
});

test("principal axes turn an inertia into its moments", () => {
  for (const inertia of [[1, 0, 0, 0, 2, 0, 0, 0, 3], [2, 0.3, -0.1, 0.3, 1.5, 0.2, -0.1, 0.2, 1], [1, 0.5, 0, 0.5, 1, 0, 0, 0, 2]]) {
    const { moments, axes } = principal(inertia);
    axes.forEach((a, k) => {
      near([0, 1, 2].map((i) => a.reduce((n, x, j) => n + inertia[3 * i + j] * x, 0)), a.map((x) => moments[k] * x));
    });
    const [x, y, z] = axes;
    near([x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]], z);
  }
});
