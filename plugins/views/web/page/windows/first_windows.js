// @ts-check
// Opens the plots of a scene's graphs at its first start in this browser, as V-REP shows them. Later, the windows are those
// that the user has left open.

import * as THREE from "three";
import { get } from "tatu/lib/dom";
import { hasPlacement, storePlacement } from "tatu/lib/floating_window";
import { on } from "tatu/net/connection";
import { scene } from "tatu/scene/store";
import { worldPosition } from "tatu/view/picking";
import { camera } from "tatu/view/renderer";
import { hasLayout, isWindowOpen, openWindow } from "tatu/windows/open_windows";
import { graphSpec, plotKey } from "tatu/windows/plot_window";

/** Maximum number of plots that are opened. */
const MAX_PLOTS = 2;
/** Minimum width of the view, pixels; in a narrower one, a plot would hide the scene. */
const MIN_VIEW_WIDTH = 600;
/** Distance of plots from the edges of the view, and between tried places, pixels. */
const [MARGIN, STEP] = [10, 24];
/** Space around the origin of a model, pixels. */
const MODEL_RADIUS = 60;

const host = get("view");

/** Returns the positions of the models in the view, pixels. */
function modelPositions() {
  const models = [...scene.objects.values()].filter((o) => o.model && o.parent === 0);
  return models.flatMap((o) => {
    const p = worldPosition(o.id).project(camera);
    const isInView = Math.abs(p.x) <= 1 && Math.abs(p.y) <= 1 && Math.abs(p.z) <= 1;
    return isInView ? [new THREE.Vector2(((p.x + 1) / 2) * host.clientWidth, ((1 - p.y) / 2) * host.clientHeight)] : [];
  });
}

/**
 * Returns a place for a plot at the right or left edge of the view, beside the models and the open windows, or null if there
 * is none.
 * @param {number} w width of the plot, pixels
 * @param {number} h
 */
function freePlace(w, h) {
  const windows = /** @type {HTMLElement[]} */ ([...host.querySelectorAll(".window, .over")]).filter((o) => o.offsetWidth > 0);
  const boxes = windows.map((o) => [o.offsetLeft, o.offsetTop, o.offsetLeft + o.offsetWidth, o.offsetTop + o.offsetHeight]);
  for (const p of modelPositions()) boxes.push([p.x - MODEL_RADIUS, p.y - MODEL_RADIUS, p.x + MODEL_RADIUS, p.y + MODEL_RADIUS]);
  for (const x of [host.clientWidth - w - MARGIN, MARGIN]) {
    for (let y = MARGIN; y <= host.clientHeight - h - MARGIN; y += STEP) {
      if (!boxes.some(([x0 = 0, y0 = 0, x1 = 0, y1 = 0]) => x < x1 && x0 < x + w && y < y1 && y0 < y + h)) return { x, y };
    }
  }
  return null;
}

function openPlots() {
  if (hasLayout() || host.clientWidth < MIN_VIEW_WIDTH) return;
  const [w, h] = [Math.min(420, Math.floor(host.clientWidth / 3)), Math.min(260, Math.floor(host.clientHeight / 3))];
  const graphs = [...scene.objects.values()].filter((o) => o.kind === "graph").slice(0, MAX_PLOTS);
  for (const { id } of graphs) {
    const spec = graphSpec(id);
    const place = freePlace(w, h);
    if (!place || isWindowOpen("plot", spec)) continue;
    if (!hasPlacement(plotKey(spec))) storePlacement(plotKey(spec), [place.x, place.y, w, h]);
    openWindow("plot", spec);
  }
}
on("event", ({ name }) => { if (name === "started") openPlots(); });
