import assert from "node:assert/strict";
import { test } from "node:test";

import { formatNumber } from "../lib/numbers.js";
import { colorOf, formOf, groupOf, hexOf, labelOf, nameOf, partNames, encodeNumber, unitOf } from "../scene/property_format.js";

test("names in words", () => {
  assert.equal(nameOf("joint.max_force"), "Maximum force");
  assert.equal(nameOf("object.alias"), "Name");
  assert.equal(nameOf("shape.com"), "Centre of mass");
  assert.equal(nameOf("proximity.min_range"), "Minimum range");
  assert.equal(nameOf("acme.sensor.lidar.scan_rate"), "Scan rate");
  assert.equal(nameOf("distance"), "Distance");
});

test("groups", () => {
  const all = [
    ["object.position", "shape", "Place"], ["object.pose", "shape", "More"], ["shape.size", "shape", "Shape"], ["shape.mass", "shape", "Physics"],
    ["joint.limits", "joint", "Joint"], ["proximity.range", "sensor", "Sensor"], ["distance", "sensor", "Reading"],
    ["motor.power", "actuator", "Drive"], ["object.drive", "shape", "Drive"], ["camera.angle", "camera", "Camera"],
    ["force_sensor.force", "force_sensor", "Sensor"],
  ];
  for (const [key, kind, wanted] of all) assert.equal(groupOf(key, kind), wanted, key);
});

test("degrees stand for rad, also in units of joints", () => {
  assert.equal(formatNumber(Math.PI / 4, unitOf("rad").factor), "45");
  assert.equal(unitOf("rad|m").text, "\u00b0");
  assert.deepEqual(unitOf("rad|m", true), { text: "m", factor: 1 });
  assert.equal(unitOf("rad/s|m/s").text, "\u00b0/s");
  assert.equal(unitOf("N m|N", true).text, "N");
  assert.equal(unitOf("kg m^2", true).text, "kg m^2");
});

test("numbers as they are read and sent", () => {
  assert.equal(formatNumber(0.1 + 0.2), "0.3");
  assert.equal(formatNumber(-0), "0");
  assert.equal(formatNumber({ number: "-inf" }), "-\u221e");
  assert.equal(formatNumber(null), "");
  assert.deepEqual([encodeNumber(2), encodeNumber(-Infinity)], [2, { number: "-inf" }]);
});

test("labels of edits", () => {
  assert.equal(labelOf("object.position", "cup"), "Move cup");
  assert.equal(labelOf("shape.mass", "cup"), "Set mass of cup");
  assert.equal(labelOf("object.alias", "cup"), "Rename cup");
});

test("colors there and back", () => {
  assert.equal(hexOf([1, 0.5, 0]), "#ff8000");
  assert.equal(hexOf(colorOf("#12ab9f")), "#12ab9f");
});

test("how values are shown", () => {
  const row = (more) => ({ key: "a.b", type: 4, count: 0, unit: "", text: "", settable: true, choices: [], value: "", ...more });
  assert.equal(formOf(row({})), "text");
  assert.equal(formOf(row({ choices: ["a"] })), "choice");
  assert.equal(formOf(row({ type: 1, value: true })), "check");
  assert.equal(formOf(row({ type: 3, value: { number: "inf" } })), "number");
  assert.equal(formOf(row({ type: 6, count: 3, value: [1, 2, 3] })), "parts");
  assert.equal(formOf(row({ type: 6, count: 7, value: [0, 0, 0, 0, 0, 0, 1] })), "numbers");
  assert.equal(formOf(row({ type: 6, count: 3, key: "light.color", value: [1, 1, 1] })), "color");
  assert.equal(formOf(row({ type: 11, value: [] })), "texts");
  assert.equal(formOf(row({ type: 11, value: [{ a: 1 }] })), "table");
  assert.equal(formOf(row({ type: 12, value: { a: 1 } })), "table");
  assert.equal(formOf(row({ type: 14, value: 7 })), "object");
  assert.deepEqual(partNames("joint.limits", 2), ["from", "to"]);
  assert.deepEqual(partNames("object.position", 3), ["x", "y", "z"]);
});
