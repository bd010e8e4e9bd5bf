// @ts-check
// The window that lists all sensors with their current readings.

import { make } from "tatu/lib/dom";
import { openFloatingWindow } from "tatu/lib/floating_window";
import { icon } from "tatu/lib/icons";
import { t } from "tatu/lib/language";
import { on } from "tatu/net/connection";
import { unwatch, watchValue } from "tatu/net/watched_values";
import { editState } from "tatu/scene/edits";
import { nameInModel } from "tatu/scene/hierarchy";
import { nameOf } from "tatu/scene/property_format";
import { scene, select, selection, watch } from "tatu/scene/store";
import { cameraSpec } from "tatu/windows/camera_window";
import { registerWindow, toggleWindow, windowClosed } from "tatu/windows/open_windows";

/** @import { Reading } from "tatu/protocol" */
/** @import { Series } from "tatu/net/watched_values" */

/** Maximum number of force sensors whose forces are shown. */
const MAX_FORCES = 40;

/** Formats a number with up to four significant digits, or a dash. @param {number | null | undefined} x */
const formatShort = (x) => (typeof x === "number" ? String(+x.toPrecision(4)) : "\u2014");

/**
 * Formats a reading as short text for the list.
 * @param {Reading} r
 */
export function formatReading(r) {
  switch (r.schema) {
    case "proximity": return r.detected ? `${formatShort(r.distance)} m` : t`nothing`;
    case "gps": return `${r.position.map(formatShort).join(", ")} m`;
    case "range_scan": {
      const hits = r.distance.filter((d) => d !== null);
      return hits.length ? t`nearest ${formatShort(Math.min(...hits))} m, ${hits.length} of ${r.distance.length} beams` : t`nothing`;
    }
    case "fields": {
      const all = Object.entries(r.fields);
      return all.map(([name, numbers]) => `${all.length > 1 ? `${nameOf(name)} ` : ""}${numbers.map(formatShort).join(", ")}`).join("; ");
    }
  }
}

/** @type {Map<number, Reading>} */
const lastReadings = new Map();
on("readings", ({ readings }) => {
  for (const [key, reading] of Object.entries(readings)) {
    if (reading) lastReadings.set(Number(key), reading);
    else lastReadings.delete(Number(key));
  }
});
// Readings from an earlier scene or from before a reset are no longer valid.
const clearReadings = () => lastReadings.clear();
on("event", ({ name }) => { if (name === "stopped") clearReadings(); });
watch("scene", () => { if (scene.isNew) clearReadings(); });

function openSensors() {
  const window = openFloatingWindow({ key: "sensors", title: t`Sensors`, width: 340, height: 260, closed });
  const pane = { kind: "sensors", spec: {}, close: window.close };
  const table = make("table", { className: "sensors" });
  const body = make("tbody");
  table.append(body);
  window.body.append(table);
  /** @type {Map<number, HTMLElement>} */
  const cells = new Map();
  let isScheduled = false;
  let listKey = "";
  /** The watched forces of force sensors, which do not have readings. @type {Series[]} */
  let forceSeries = [];

  function list() {
    const all = [...scene.objects.values()];
    const forces = all.filter((o) => o.kind === "force_sensor");
    const sensors = [...all.filter((o) => o.kind === "sensor"), ...forces];
    const now = JSON.stringify(sensors.map((o) => [o.id, o.alias, o.sensor, o.schema]));
    if (now === listKey) return;
    listKey = now;
    cells.clear();
    const previousSeries = forceSeries;
    forceSeries = forces.slice(0, MAX_FORCES).map((o) => watchValue(o.id, "force_sensor.force"));
    previousSeries.forEach(unwatch);
    body.replaceChildren(...sensors.map((o) => {
      const row = make("tr");
      const name = make("button", { type: "button", className: "link", textContent: nameInModel(o), title: o.alias, onclick: () => select(o.id) });
      const cell = make("td", { className: "value" });
      const [header, kind] = [make("th"), make("td", { textContent: (o.sensor ?? o.kind).replaceAll("_", " ") })];
      header.scope = "row";
      header.append(name);
      row.append(header, kind, cell);
      row.dataset.id = String(o.id);
      if (o.schema === "image") {
        const imageButton = make("button", { type: "button", className: "tool", title: t`Show its image`, onclick: () => toggleWindow("camera", cameraSpec(o.id)) });
        imageButton.setAttribute("aria-label", t`Show the image of ${o.alias}`);
        imageButton.append(icon("camera"));
        cell.append(imageButton);
      } else cells.set(o.id, cell);
      return row;
    }));
    if (!sensors.length) {
      const row = make("tr");
      row.append(make("td", { textContent: t`This scene has no sensors.` }));
      body.append(row);
    }
    window.title.textContent = t`Sensors (${sensors.length})`;
    show();
    mark();
  }
  function show() {
    isScheduled = false;
    for (const [id, cell] of cells) {
      const reading = lastReadings.get(id);
      const text = reading ? formatReading(reading) : "\u2014";
      if (cell.textContent !== text) cell.textContent = text;
    }
    for (const { object, numbers } of forceSeries) {
      const force = editState.state !== "stopped" ? numbers.at(-1)?.map((x) => x ?? 0) : undefined;
      const cell = cells.get(object);
      if (cell) cell.textContent = force?.length ? `${formatShort(Math.hypot(...force))} N` : "\u2014";
    }
  }
  function mark() {
    const chosen = selection();
    for (const row of body.rows) row.classList.toggle("on", chosen.includes(Number(row.dataset.id)));
  }
  const scheduleShow = () => {
    if (isScheduled) return;
    isScheduled = true;
    requestAnimationFrame(show);
  };
  const listHandle = { list, schedule: scheduleShow, mark };
  lists.add(listHandle);
  function closed() {
    forceSeries.forEach(unwatch);
    lists.delete(listHandle);
    windowClosed(pane);
  }
  list();
  return pane;
}
/** @type {Set<{ list: () => void, schedule: () => void, mark: () => void }>} */
const lists = new Set();
registerWindow("sensors", openSensors);
on("readings", () => { for (const l of lists) l.schedule(); });
on("values", () => { for (const l of lists) l.schedule(); });
on("event", ({ name }) => { if (name === "stopped") for (const l of lists) l.schedule(); });
for (const change of /** @type {const} */ (["scene", "objects"])) watch(change, () => { for (const l of lists) l.list(); });
watch("selected", () => { for (const l of lists) l.mark(); });
