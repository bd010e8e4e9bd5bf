// @ts-check
// Draws the detection volume of the selected sensor, in another color while the sensor detects an object.

import * as THREE from "three";
import { on } from "tatu/net/connection";
import { scene, selected, watch } from "tatu/scene/store";
import { attachTo } from "tatu/view/instancing";
import { groups } from "tatu/view/objects";
import { redraw } from "tatu/view/renderer";
import { volumeGeometry } from "tatu/view/volume_geometry";

const FREE_COLOR = 0x2a9d5c;
const HIT_COLOR = 0xe0352b;
const fill = new THREE.MeshBasicMaterial({ color: FREE_COLOR, transparent: true, opacity: 0.18, side: THREE.DoubleSide, depthWrite: false });
const edge = new THREE.LineBasicMaterial({ color: FREE_COLOR, transparent: true, opacity: 0.6 });

/** @type {THREE.Group | null} */
let shownVolume = null;
/** Draws the detection volume of an object, if it is a sensor that has one. @param {number} id */
function show(id) {
  shownVolume?.removeFromParent();
  shownVolume?.traverse((x) => {
    if (x instanceof THREE.Mesh || x instanceof THREE.LineSegments) x.geometry.dispose();
  });
  shownVolume = null;
  const group = groups.get(id);
  const surface = group && volumeGeometry(scene.objects.get(id)?.volume ?? {});
  if (!surface) return;
  shownVolume = new THREE.Group();
  shownVolume.add(new THREE.Mesh(surface, fill), new THREE.LineSegments(new THREE.EdgesGeometry(surface, 30), edge));
  attachTo(group, shownVolume);
  redraw();
}
watch("selected", show);
watch("scene", () => show(selected()));
watch("objects", (changed) => { if (changed.some((o) => o.id === selected())) show(selected()); });
on("readings", ({ readings }) => {
  const reading = readings[selected()];
  if (reading === undefined || !shownVolume) return;
  const detected = reading?.schema === "proximity" && reading.detected;
  for (const material of [fill, edge]) material.color.setHex(detected ? HIT_COLOR : FREE_COLOR);
});
