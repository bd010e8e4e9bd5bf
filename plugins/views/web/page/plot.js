// @ts-check
// Curves on a canvas.

/**
 * A curve; its color from 0 to 1.
 * @typedef {{ name: string, unit?: string, color?: number[] | null, times: (number | null)[], values: (number | null)[] }} Curve
 */

/**
 * Draws curves. `unit` stands along.
 * @param {HTMLCanvasElement} canvas
 * @param {Curve[]} curves
 */
export function plot(canvas, curves, unit = "s") {
  const c = canvas.getContext("2d");
  if (!c) return;
  const [w, h] = [canvas.width, canvas.height];
  c.clearRect(0, 0, w, h);
  /** @returns {[number, number]} */
  const range = (/** @type {"times" | "values"} */ key) => {
    let [low, high] = [Infinity, -Infinity];
    for (const curve of curves) {
      for (const x of curve[key]) {
        if (x === null) continue;
        low = Math.min(low, x);
        high = Math.max(high, x);
      }
    }
    return [low, high];
  };
  const [low, high] = range("values");
  const [from, to] = range("times");
  if (!(low <= high)) return;
  const x = (/** @type {number} */ t) => 34 + ((w - 40) * (t - from)) / (to - from || 1);
  const y = (/** @type {number} */ v) => h - 16 - ((h - 30) * (v - low)) / (high - low || 1);
  c.font = "11px sans-serif";
  c.fillStyle = getComputedStyle(canvas).color;
  c.fillText(high.toPrecision(3), 0, 12);
  c.fillText(low.toPrecision(3), 0, h - 16);
  c.fillText(`${from.toFixed(1)} ${unit}`, 34, h - 2);
  c.fillText(`${to.toFixed(1)} ${unit}`, w - 40, h - 2);
  curves.forEach((s, i) => {
    const [r, g, b] = (s.color ?? [0.2, 0.5, 0.9]).map((v) => Math.round(255 * v));
    c.strokeStyle = c.fillStyle = `rgb(${r} ${g} ${b})`;
    c.beginPath();
    s.values.forEach((v, k) => { if (v !== null) c.lineTo(x(s.times[k] ?? 0), y(v)); });
    c.stroke();
    c.fillText(`${s.name} ${s.unit ? `(${s.unit})` : ""}`, 40, 12 + 12 * i);
  });
}
