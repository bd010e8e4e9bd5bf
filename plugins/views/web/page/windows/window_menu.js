// @ts-check
// The menu of windows that can be opened: the list of sensors, images of cameras, and plots of graphs.

import { get } from "tatu/lib/dom";
import { openMenu } from "tatu/lib/menu";
import { pathOf } from "tatu/scene/hierarchy";
import { scene } from "tatu/scene/store";
import { cameraSpec, hasImage } from "tatu/windows/camera_window";
import { isWindowOpen, toggleWindow } from "tatu/windows/open_windows";
import { graphSpec } from "tatu/windows/plot_window";
import "tatu/windows/sensor_window";

/** Maximum number of objects per kind in the menu. */
const MAX_ENTRIES = 12;

/**
 * Returns the kind and description of the window that shows an object, or null if there is none.
 * @param {number} id
 * @returns {{ kind: string, spec: unknown } | null}
 */
export function windowOf(id) {
  if (hasImage(id)) return { kind: "camera", spec: cameraSpec(id) };
  if (scene.objects.get(id)?.kind === "graph") return { kind: "plot", spec: graphSpec(id) };
  return null;
}

const button = get("windows");
button.onclick = () => {
  const all = [...scene.objects.values()];
  const groups = [all.filter((o) => hasImage(o.id)), all.filter((o) => o.kind === "graph")];
  const entries = [{ name: "Sensors", kind: "sensors", spec: /** @type {unknown} */ ({}) }];
  for (const group of groups) {
    for (const o of group.slice(0, MAX_ENTRIES)) {
      const window = windowOf(o.id);
      if (window) entries.push({ name: pathOf(o.id).slice(1), ...window });
    }
  }
  const box = button.getBoundingClientRect();
  openMenu(box.left, box.bottom + 2, entries.map(({ name, kind, spec }) => (
    { name, keys: isWindowOpen(kind, spec) ? "\u2713" : "", action: () => toggleWindow(kind, spec), isDisabled: false }
  )));
};
