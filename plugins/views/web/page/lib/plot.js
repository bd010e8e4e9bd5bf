// @ts-check
// Draws curves on a canvas, with a grid, axes labelled with round numbers, and colors that color-blind people can
// distinguish.

/**
 * A curve. `times` are the values on the horizontal axis: times, or the x values of an x-y curve. The components of
 * `color` are from 0 to 1. Without `color`, the curve has the default color with the index `place`, which defaults to
 * the index of the curve.
 * @typedef {{ name: string, unit?: string, color?: number[] | null, place?: number, times: (number | null)[], values: (number | null)[] }} Curve
 */

/** Default colors of curves, from the palette by Okabe and Ito. */
const COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
/** Minimum distance between grid lines, pixels. */
const GRID_SPACING = { x: 70, y: 28 };

/**
 * Returns the CSS color of a curve.
 * @param {Curve["color"]} color
 * @param {number} i index of the default color
 */
export function colorOf(color, i) {
  return color ? `rgb(${color.map((v) => Math.round(255 * v)).join(" ")})` : COLORS[i % COLORS.length] ?? "";
}

/**
 * Returns round numbers from `low` to `high`, not more than about `count`, and the number of decimal places that they
 * require.
 * @param {number} low
 * @param {number} high
 * @param {number} count
 */
export function ticks(low, high, count) {
  const roughStep = Math.max((high - low) / Math.max(1, count), Number.MIN_VALUE);
  const power = 10 ** Math.floor(Math.log10(roughStep));
  const step = power * ([1, 2, 5, 10].find((n) => n * power >= roughStep * (1 - 1e-9)) ?? 10);
  const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  /** @type {number[]} */
  const all = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step && all.length <= count + 1; i++) all.push(i * step + 0);
  return { all, digits };
}

/**
 * Returns the range of the times or values of curves, or null if there are none. The range of values has a margin.
 * @param {Curve[]} curves
 * @param {"times" | "values"} key
 */
function range(curves, key) {
  let [low, high] = [Infinity, -Infinity];
  for (const curve of curves) {
    for (const x of curve[key]) {
      if (x === null) continue;
      low = Math.min(low, x);
      high = Math.max(high, x);
    }
  }
  if (low > high) return null;
  // The range around a constant value is chosen so that the curve is drawn in the middle.
  const margin = high > low ? (key === "values" ? 0.04 * (high - low) : 0) : Math.max(Math.abs(high) * 0.1, 1e-3);
  return { low: low - margin, high: high + margin };
}

/**
 * Extends one of two ranges about its middle, so that a unit has the same length on both axes.
 * @param {{ low: number, high: number }} x
 * @param {number} width of the axis, pixels
 * @param {{ low: number, high: number }} y
 * @param {number} height of the axis, pixels
 */
export function equalize(x, width, y, height) {
  const scale = Math.max((x.high - x.low) / width, (y.high - y.low) / height);
  for (const [range, length] of /** @type {[typeof x, number][]} */ ([[x, width], [y, height]])) {
    const missing = (scale * length - (range.high - range.low)) / 2;
    range.low -= missing;
    range.high += missing;
  }
}

/**
 * Formats the label of a tick.
 * @param {number} x
 * @param {number} digits number of decimal places
 */
function label(x, digits) {
  return digits > 6 || Math.abs(x) >= 1e6 ? x.toExponential(1) : (x + 0).toFixed(digits).replace(/^-0(\.0*)?$/, "0$1");
}

/** Maximum number of times that the layout of a plot is improved, of which usually one or two suffice. */
const MAX_LAYOUTS = 5;
/** Space above and below the curves, pixels. */
const [TOP, BOTTOM] = [10, 20];

/**
 * Returns the space at the left and right of curves, for the labels of the axes, and the ranges and ticks of the axes.
 * @param {{ low: number, high: number }} timeRange
 * @param {{ low: number, high: number }} valueRange
 * @param {number} w width of the canvas, pixels
 * @param {number} h
 * @param {string} unit of the horizontal axis
 * @param {boolean} isEqual whether a unit has the same length on both axes
 * @param {(text: string) => number} widthOf returns the width of a text, pixels
 */
export function layout(timeRange, valueRange, w, h, unit, isEqual, widthOf) {
  let [left, right] = [22, 10];
  // Equal scales extend a range, which may then need longer labels, which leave less space for the curves.
  for (let n = 0; ; n++) {
    const [times, values] = [{ ...timeRange }, { ...valueRange }];
    if (isEqual) equalize(times, Math.max(1, w - left - right), values, h - TOP - BOTTOM);
    const valueTicks = ticks(values.low, values.high, Math.floor((h - 34) / GRID_SPACING.y));
    const timeTicks = ticks(times.low, times.high, Math.floor((w - left) / GRID_SPACING.x));
    const neededLeft = 10 + Math.max(...valueTicks.all.map((v) => widthOf(label(v, valueTicks.digits))), 12);
    // The unit is at the right of the last label, which is below the end of the curves.
    const neededRight = unit ? 8 + widthOf(unit) + widthOf(label(timeTicks.all.at(-1) ?? times.high, timeTicks.digits)) / 2 : 10;
    if ((neededLeft <= left && neededRight <= right) || n === MAX_LAYOUTS) return { left, right, times, values, valueTicks, timeTicks };
    [left, right] = [Math.max(left, Math.ceil(neededLeft)), Math.max(right, Math.ceil(neededRight))];
  }
}

/**
 * Draws curves.
 * @param {HTMLCanvasElement} canvas
 * @param {Curve[]} curves
 * @param {string} [unit] of the horizontal axis
 * @param {boolean} [legend] whether to draw the names and units of the curves
 * @param {boolean} [isEqual] whether a unit has the same length on both axes, as on a map
 */
export function plot(canvas, curves, unit = "s", legend = true, isEqual = false) {
  const c = canvas.getContext("2d");
  if (!c) return;
  const scale = canvas.clientWidth ? canvas.width / canvas.clientWidth : 1;
  const [w, h] = [canvas.width / scale, canvas.height / scale];
  c.setTransform(scale, 0, 0, scale, 0, 0);
  c.clearRect(0, 0, w, h);
  const [valueRange, timeRange] = [range(curves, "values"), range(curves, "times")];
  if (!valueRange || !timeRange) return;
  c.font = "11px system-ui, sans-serif";
  const textColor = getComputedStyle(canvas).color;
  const widthOf = (/** @type {string} */ text) => c.measureText(text).width;
  const { left, right, times, values, valueTicks, timeTicks } = layout(timeRange, valueRange, w, h, unit, isEqual, widthOf);
  const x = (/** @type {number} */ t) => left + ((w - left - right) * (t - times.low)) / (times.high - times.low);
  const y = (/** @type {number} */ v) => h - BOTTOM - ((h - TOP - BOTTOM) * (v - values.low)) / (values.high - values.low);

  c.strokeStyle = c.fillStyle = textColor;
  c.lineWidth = 1;
  const line = (/** @type {number[]} */ [x0 = 0, y0 = 0, x1 = 0, y1 = 0]) => {
    c.beginPath();
    c.moveTo(Math.round(x0) + 0.5, Math.round(y0) + 0.5);
    c.lineTo(Math.round(x1) + 0.5, Math.round(y1) + 0.5);
    c.stroke();
  };
  c.globalAlpha = 0.15;
  for (const v of valueTicks.all) line([left, y(v), w - right, y(v)]);
  for (const t of timeTicks.all) line([x(t), TOP, x(t), h - BOTTOM]);
  c.globalAlpha = 0.75;
  c.textBaseline = "middle";
  c.textAlign = "right";
  for (const v of valueTicks.all) c.fillText(label(v, valueTicks.digits), left - 5, y(v));
  c.textAlign = "center";
  for (const t of timeTicks.all) {
    const text = label(t, timeTicks.digits);
    c.fillText(text, Math.min(x(t), w - 2 - widthOf(text) / 2), h - 9);
  }
  c.textAlign = "right";
  c.fillText(unit, w - 2, h - 9);
  c.globalAlpha = 1;

  c.lineWidth = 1.5;
  c.lineJoin = "round";
  curves.forEach((s, i) => {
    c.strokeStyle = colorOf(s.color, s.place ?? i);
    c.beginPath();
    let isPenDown = false;
    s.values.forEach((v, k) => {
      const t = s.times[k];
      if (v === null || t === null || t === undefined) isPenDown = false;
      else if (isPenDown) c.lineTo(x(t), y(v));
      else {
        c.moveTo(x(t), y(v));
        isPenDown = true;
      }
    });
    c.stroke();
  });
  if (!legend) return;
  c.textAlign = "left";
  curves.forEach((s, i) => {
    c.fillStyle = colorOf(s.color, s.place ?? i);
    c.fillText(`${s.name} ${s.unit ? `(${s.unit})` : ""}`, left + 6, 17 + 13 * i);
  });
}
