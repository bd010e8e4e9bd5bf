// @ts-check
// Plot windows, which show properties and readings over time or against each other, or the streams of a graph.

import { csv, csvOfPairs } from "tatu/lib/csv";
import { make } from "tatu/lib/dom";
import { download } from "tatu/lib/download";
import { openFloatingWindow } from "tatu/lib/floating_window";
import { t } from "tatu/lib/language";
import { colorOf, plot } from "tatu/lib/plot";
import { on } from "tatu/net/connection";
import { subscribe } from "tatu/net/subscriptions";
import { unwatch, watchValue } from "tatu/net/watched_values";
import { objectAt, pathOf } from "tatu/scene/hierarchy";
import { nameOf, partNames, unitOf } from "tatu/scene/property_format";
import { scene } from "tatu/scene/store";
import { openWindow, registerWindow, storeWindows, windowClosed } from "tatu/windows/open_windows";

/** @import { CurvePoints, PropertyRow } from "tatu/protocol" */
/** @import { Curve } from "tatu/lib/plot" */
/** @import { Series } from "tatu/net/watched_values" */
/**
 * The source of a curve: an element of a property or of a field of readings. Values are multiplied by `factor` for
 * display, for example to convert rad to degrees.
 * @typedef {{ object: string, key: string, index: number, name: string, unit: string, factor: number }} CurveSource
 */
/**
 * The description of a plot: `curves` of values, or the path of a graph. `n` identifies plots of values. `along` is the
 * name of the curve that provides the horizontal axis, "" for the time, or null if the user has not chosen: then the
 * curves that the graph declares are shown if there are any, otherwise the time.
 * @typedef {{ n: number, curves: CurveSource[], graph: string, along: string | null }} Spec
 */

/** The option that shows the curves that a graph declares. No stream can have this name. */
const DECLARED = "\n";
/** The open plots. @type {Set<{ redraw: () => void, receive: (id: number, streams: Curve[], curves: CurvePoints[]) => void }>} */
const plots = new Set();
/** The plot of values that was used last. @type {{ spec: Spec, update: () => void } | null} */
let currentPlot = null;

/**
 * Returns the number of elements of a property that can be plotted, or 0 if the property cannot be plotted.
 * @param {PropertyRow} row
 */
export function plottableCount({ value }) {
  if (typeof value === "number" || typeof value === "boolean") return 1;
  return Array.isArray(value) && value.length > 0 && value.length <= 16 && value.every((v) => typeof v === "number" || v?.number) ? value.length : 0;
}

/**
 * Plots a property or a field of readings in the plot that was used last, or in a new one.
 * @param {number} object
 * @param {PropertyRow} row
 * @param {boolean} [inNewWindow] whether to open a new plot
 */
export function plotRow(object, row, inNewWindow = false) {
  const [path, n] = [pathOf(object), plottableCount(row)];
  const slides = scene.objects.get(object)?.joint?.type === "prismatic";
  const { text: unit, factor } = unitOf(row.unit, slides);
  // If several objects have the same name, curves are named after the path of the object.
  const alias = scene.objects.get(object)?.alias ?? "";
  const isAmbiguous = [...scene.objects.values()].filter((o) => o.alias === alias).length > 1;
  const owner = isAmbiguous ? path : alias;
  const labels = partNames(row.key, n);
  const curves = Array.from({ length: n }, (_, index) => {
    const name = `${owner} ${nameOf(row.key).toLowerCase()}${n > 1 ? ` ${labels[index]}` : ""}`;
    return { object: path, key: row.key, index, name, unit, factor };
  });
  if (inNewWindow || !currentPlot) {
    const spec = { n: Date.now(), curves, graph: "", along: "" };
    openWindow("plot", spec);
    return;
  }
  const isSame = (/** @type {CurveSource} */ a, /** @type {CurveSource} */ b) => a.object === b.object && a.key === b.key && a.index === b.index;
  const { spec } = currentPlot;
  spec.curves.push(...curves.filter((c) => !spec.curves.some((existing) => isSame(existing, c))));
  currentPlot.update();
  storeWindows();
}

/**
 * Returns the description of the plot of a graph.
 * @param {number} id
 */
export function graphSpec(id) {
  return { n: 0, curves: [], graph: pathOf(id), along: null };
}

/** Returns the name under which the placement of a plot is stored. @param {Spec} spec */
export const plotKey = (spec) => `plot ${spec.graph || spec.n}`;

/**
 * Combines two curves into an x-y curve. Streams of the same length are paired by index, since a script may record many
 * values at the same time, others by their times.
 * @param {Curve} x
 * @param {Curve} y
 * @returns {Curve}
 */
function pair(x, y) {
  const isOneByOne = x.times.length === y.times.length && x.times.every((t, i) => t === y.times[i]);
  if (isOneByOne) return { ...y, times: x.values };
  const at = new Map(x.times.map((t, i) => [t, x.values[i] ?? null]));
  return { ...y, times: y.times.map((t) => at.get(t) ?? null) };
}

/** Opens a plot, or returns null if none of its objects exists. @param {Spec} spec */
function openPlot(spec) {
  const graph = objectAt(spec.graph);
  if (spec.graph ? !graph : !spec.curves.some((c) => objectAt(c.object))) return null;
  const title = graph ? scene.objects.get(graph)?.alias ?? t`Graph` : t`Plot`;
  const key = plotKey(spec);
  const window = openFloatingWindow({ key, title, width: 420, height: 300, closed });
  const pane = { kind: "plot", spec, close: window.close };
  const toolbar = make("div", { className: "tools" });
  const along = make("select", { title: t`Horizontal axis` });
  along.setAttribute("aria-label", t`Horizontal axis`);
  const addTool = (/** @type {string} */ name, /** @type {string} */ hint, /** @type {() => void} */ onclick) => {
    toolbar.append(make("button", { type: "button", textContent: name, title: hint, onclick }));
  };
  toolbar.append(along);
  addTool("CSV", t`Save the values as a table`, () => saveTable());
  addTool("PNG", t`Save the picture`, () => { canvas.toBlob((blob) => { if (blob) download(blob, `${title}.png`); }); });
  const canvas = make("canvas");
  canvas.setAttribute("role", "img");
  const legend = make("ul", { className: "legend" });
  window.body.append(toolbar, canvas, legend);

  /**
   * The watched values, by the curve that shows them; null if the object of the curve does not exist.
   * @type {Map<CurveSource, Series | null>}
   */
  const series = new Map();
  /** @type {Curve[]} */
  let streams = [];
  /** The curves that the graph declares. @type {Curve[]} */
  let declared = [];
  let isScheduled = false;

  /** Returns all curves over time. @returns {Curve[]} */
  function allCurves() {
    if (graph) return streams;
    return spec.curves.map(({ name, unit, index, factor }, i) => {
      const values = series.get(/** @type {CurveSource} */ (spec.curves[i]));
      return { name, unit, times: values?.times ?? [], values: values?.numbers.map((n) => (typeof n[index] === "number" ? factor * n[index] : null)) ?? [] };
    });
  }
  /** Returns the curves of the legend. */
  const listedCurves = () => axis() === DECLARED ? declared : allCurves();
  /** Returns the chosen horizontal axis: the name of a curve, "" for the time, or DECLARED. */
  const axis = () => spec.along ?? (declared.length ? DECLARED : "");
  /**
   * Returns the curves to be drawn, and the horizontal axis: its name and unit, or null for the time; `isMap`: the axes
   * have the same unit.
   */
  function shownCurves() {
    if (axis() === DECLARED) {
      const unit = declared[0]?.unit ?? "";
      return { curves: declared.map((c, i) => ({ ...c, place: i })), x: { name: "x", unit }, isMap: true };
    }
    const curves = allCurves();
    const x = curves.find((c) => c.name === axis());
    const placed = curves.map((c, i) => ({ ...c, place: i }));
    if (!x) return { curves: placed, x: null, isMap: false };
    const others = placed.filter((c) => c.name !== x.name);
    return { curves: others.map((c) => pair(x, c)), x, isMap: others.every((c) => c.unit && c.unit === x.unit) };
  }
  function saveTable() {
    const { curves, x } = shownCurves();
    const text = x ? csvOfPairs(curves, x.unit ? `${x.name} (${x.unit})` : x.name) : csv(curves, "time (s)");
    download(new Blob([text], { type: "text/csv" }), `${title}.csv`);
  }
  function draw() {
    isScheduled = false;
    const scale = Math.min(devicePixelRatio, 2);
    const [w, h] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
    if (!w || !h) return;
    if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
    const { curves, x, isMap } = shownCurves();
    plot(canvas, curves, x ? x.unit ?? "" : "s", false, isMap);
    listedCurves().forEach((c, i) => {
      const value = legend.children[i]?.querySelector("output");
      const last = c.values.findLast((v) => v !== null);
      if (value) value.textContent = last === undefined || last === null ? "" : `${+last.toPrecision(4)} ${c.unit ?? ""}`;
    });
  }
  const redraw = () => {
    if (isScheduled) return;
    isScheduled = true;
    requestAnimationFrame(draw);
  };
  let listKey = "";
  function list() {
    const curves = listedCurves();
    const names = allCurves().map((c) => c.name);
    const now = JSON.stringify([names, declared.length > 0, curves.map((c) => [c.name, c.unit, c.color])]);
    if (now === listKey) return;
    listKey = now;
    const ofGraph = declared.length ? [new Option(t`curves of the graph`, DECLARED)] : [];
    along.replaceChildren(...ofGraph, new Option(t`time`, ""), ...names.map((name) => new Option(name, name)));
    along.value = axis() === DECLARED && declared.length || names.includes(axis()) ? axis() : "";
    canvas.setAttribute("aria-label", t`Plot of ${curves.map((c) => c.name).join(", ") || t`nothing yet`}`);
    legend.replaceChildren(...curves.map((c, i) => {
      const item = make("li");
      const swatch = make("span", { className: "swatch" });
      swatch.style.background = colorOf(c.color, i);
      item.append(swatch, make("span", { textContent: c.name }), make("output"));
      if (graph) return item;
      const removeButton = make("button", { type: "button", textContent: "\u00D7", title: t`Remove this curve` });
      removeButton.setAttribute("aria-label", t`Remove ${c.name}`);
      removeButton.onclick = () => {
        spec.curves.splice(i, 1);
        if (!spec.curves.length) return window.close();
        update();
        storeWindows();
      };
      item.append(removeButton);
      return item;
    }));
  }
  /** Watches the values of the current curves, and stops watching others. */
  function update() {
    for (const [curve, values] of series) {
      if (spec.curves.includes(curve)) continue;
      if (values) unwatch(values);
      series.delete(curve);
    }
    for (const curve of spec.curves) {
      if (series.has(curve)) continue;
      const id = objectAt(curve.object);
      series.set(curve, id ? watchValue(id, curve.key) : null);
    }
    list();
    redraw();
  }
  along.onchange = () => {
    spec.along = along.value;
    list();
    redraw();
    storeWindows();
  };
  const plotHandle = { spec, update };
  const makeCurrent = () => { if (!graph) currentPlot = plotHandle; };
  window.box.addEventListener("pointerdown", makeCurrent, true);
  const sizeObserver = new ResizeObserver(redraw);
  sizeObserver.observe(canvas);
  const plotListener = { redraw, receive: (/** @type {number} */ id, /** @type {Curve[]} */ now, /** @type {CurvePoints[]} */ curves) => {
    if (id !== graph) return;
    streams = now;
    declared = curves.map(({ x, y, ...c }) => ({ ...c, times: x, values: y }));
    list();
    redraw();
  } };
  plots.add(plotListener);
  if (graph) subscribe("graphs", key, graph);
  function closed() {
    for (const curve of series.values()) if (curve) unwatch(curve);
    if (graph) subscribe("graphs", key, 0);
    plots.delete(plotListener);
    sizeObserver.disconnect();
    if (currentPlot === plotHandle) currentPlot = null;
    windowClosed(pane);
  }
  makeCurrent();
  update();
  return pane;
}
registerWindow("plot", openPlot, (spec) => spec.graph || String(spec.n));

on("values", () => { for (const p of plots) p.redraw(); });
on("event", ({ name }) => { if (name === "started") for (const p of plots) p.redraw(); });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { for (const p of plots) p.redraw(); });

on("streams", ({ graph, streams, curves }) => { for (const p of plots) p.receive(graph, streams, curves); });
