// @ts-check
// Creates the widgets of script windows, and updates them when the script changes their state.

import { make } from "tatu/lib/dom";
import { plot } from "tatu/lib/plot";
import { applyStyle, setRichText } from "tatu/windows/rich_text";

/**
 * The state of a widget, which the script sets.
 * @typedef {{ [key: string]: any }} Values
 */
/** @typedef {{ element: string, above?: number | null, values: Values }} Widget `above` is the index of its parent */
/**
 * The widgets of a window, their elements, and the function that reports user actions to the script.
 * @typedef {{ widgets: Widget[], elements: HTMLElement[], report: (n: number, what: string, value?: unknown) => void }} WidgetWindow
 */
/** @typedef {(what: string, value?: unknown) => void} Report reports a user action on a widget to the script */
/**
 * @template {HTMLElement} E
 * @typedef {{ make: (v: Values, report: Report) => E, set: (e: E, v: Values, report: Report) => void }} Kind
 */

/**
 * Creates an input for a number.
 * @param {Values} v
 * @param {string} type "range" or "number"
 */
function numberInput(v, type) {
  const input = make("input", { type, min: v.minimum ?? 0, max: v.maximum ?? 100, step: v.step ?? 1, value: v.value ?? 0 });
  if (type === "number" && v.float) input.step = v.step && v.step !== 1 ? v.step : "any";
  return input;
}

/** The types of widgets: `make` creates the element, and `set` updates it from the state. */
/** @type {{ [element: string]: Kind<any> | undefined }} */
const WIDGETS = {
  label: {
    make: () => make("div", { className: "label" }),
    set: (e, v, report) => setRichText(e, v.text, (link) => report("link", link)),
  },
  "text-browser": { make: () => make("div", { className: "text" }), set: (e, v, report) => setRichText(e, v.text, (link) => report("link", link)) },
  button: {
    make: (v, report) => v.held ? holdButton(report) : make("button", { onclick: () => report("click") }),
    set: (e, v) => {
      e.textContent = v.text ?? "";
      if (v.checkable) e.setAttribute("aria-pressed", String(v.checked === true));
    },
  },
  hslider: { make: (v, report) => slider(v, report), set: (e, v) => updateNumber(e, v) },
  vslider: { make: (v, report) => Object.assign(slider(v, report), { className: "upright" }), set: (e, v) => updateNumber(e, v) },
  spinbox: {
    make: (v, report) => {
      const input = numberInput(v, "number");
      input.onchange = () => report("change", Number(input.value));
      return input;
    },
    set: (e, v) => updateNumber(e, v),
  },
  edit: {
    make: (v, report) => {
      const input = make("input", { type: "text" });
      input.onchange = () => report("change", input.value);
      return input;
    },
    set: (e, v) => { if (e !== document.activeElement) e.value = v.value ?? ""; },
  },
  checkbox: { make: (v, report) => checkableLabel("checkbox", (on) => report("change", on)), set: updateCheckable },
  radiobutton: { make: (v, report) => checkableLabel("radio", () => report("click")), set: updateCheckable },
  progressbar: {
    make: () => make("progress"),
    set: (e, v) => {
      e.max = (v.maximum ?? 100) - (v.minimum ?? 0) || 1;
      e.value = (v.value ?? 0) - (v.minimum ?? 0);
    },
  },
  combobox: {
    make: (v, report) => {
      const list = make("select");
      list.onchange = () => report("change", list.selectedIndex);
      return list;
    },
    set: (e, v) => {
      e.replaceChildren(...(v.items ?? []).map((/** @type {string} */ text) => new Option(text)));
      e.selectedIndex = v.index ?? 0;
    },
  },
  table: {
    make: () => make("table"),
    set: (e, v) => {
      const row = (/** @type {string[]} */ cells, /** @type {"td" | "th"} */ tag) => {
        const tr = make("tr");
        tr.append(...cells.map((text) => make(tag, { textContent: text })));
        return tr;
      };
      e.replaceChildren(...(v.headers?.length ? [row(v.headers, "th")] : []), ...(v.rows ?? []).map((/** @type {string[]} */ r) => row(r, "td")));
    },
  },
  tree: {
    make: () => make("ul", { className: "items" }),
    set: (e, v, report) => {
      /** @type {{ id: number, above?: number, texts: string[], open?: boolean }[]} */
      const rows = v.rows ?? [];
      /** @returns {HTMLElement[]} */
      const below = (/** @type {number} */ id) => rows.filter((r) => (r.above ?? 0) === id).map((r) => {
        const li = make("li");
        const b = make("button", { textContent: r.texts.join("  "), onclick: () => report("select", r.id) });
        b.classList.toggle("on", v.selected === r.id);
        li.append(b);
        const inner = below(r.id);
        if (r.open && inner.length) {
          const ul = make("ul");
          ul.append(...inner);
          li.append(ul);
        }
        return li;
      });
      e.replaceChildren(...below(0));
    },
  },
  image: { make: () => make("canvas", { width: 1, height: 1 }), set: updateImage },
  svg: { make: () => make("img", { alt: "" }), set: updateSvg },
  plot: {
    make: () => make("canvas", { width: 320, height: 200 }),
    set: (e, v) => {
      /** @type {{ name: string, kind: number, color?: number[], x: number[], y: number[] }[]} */
      const all = v.curves ?? [];
      const curves = all.map((c) => ({ name: c.name, color: (c.color ?? [200, 0, 0]).map((x) => x / 255), times: c.x, values: c.y }));
      plot(e, curves, all.every((c) => c.kind === 0) ? "s" : "");
    },
  },
  br: { make: () => make("span", { className: "br" }), set: () => {} },
  stretch: { make: () => make("span", { className: "stretch" }), set: () => {} },
};
/** Types of widgets that contain other widgets. */
const BOXES = new Set(["ui", "group", "tabs", "tab"]);

/**
 * Creates a button that reports presses and releases separately.
 * @param {Report} report
 */
function holdButton(report) {
  const button = make("button");
  button.onpointerdown = (e) => {
    button.setPointerCapture(e.pointerId);
    report("press");
  };
  button.onpointerup = button.onpointercancel = () => report("release");
  // A click by the keyboard does not cause pointer events, so it is reported here as a press and a release.
  button.onclick = (e) => {
    if (e.detail !== 0) return;
    report("press");
    report("release");
  };
  return button;
}

/**
 * Creates a slider.
 * @param {Values} v
 * @param {Report} report
 */
function slider(v, report) {
  const input = numberInput(v, "range");
  input.oninput = () => report("change", Number(input.value));
  return input;
}

/**
 * Updates an input for a number, but not its value while it has the focus.
 * @param {HTMLInputElement} e
 * @param {Values} v
 */
function updateNumber(e, v) {
  Object.assign(e, { min: v.minimum ?? 0, max: v.maximum ?? 100 });
  if (e !== document.activeElement) e.value = v.value ?? 0;
}

/**
 * Creates a check box or radio button with a label.
 * @param {"checkbox" | "radio"} type
 * @param {(on: boolean) => void} report
 */
function checkableLabel(type, report) {
  const label = make("label");
  const input = make("input", { type });
  input.onchange = () => report(input.checked);
  label.append(input, make("span"));
  return label;
}

/**
 * Updates a check box or radio button.
 * @param {HTMLLabelElement} e
 * @param {Values} v
 */
function updateCheckable(e, v) {
  const [input, text] = e.children;
  if (!(input instanceof HTMLInputElement && text instanceof HTMLElement)) return;
  input.checked = v.checked > 0;
  input.indeterminate = v.checked === 1 && input.type === "checkbox";
  setRichText(text, v.text);
}

/**
 * Updates an image. Its rows are stored from top to bottom.
 * @param {HTMLCanvasElement} e
 * @param {Values} v
 */
function updateImage(e, v) {
  const [w, h] = [v.columns, v.rows];
  if (!v.pixels?.bytes || !(w > 0 && h > 0)) return;
  const bytes = Uint8Array.from(atob(v.pixels.bytes), (c) => c.charCodeAt(0));
  Object.assign(e, { width: w, height: h });
  const image = new ImageData(w, h);
  for (let i = 0; i < w * h; i++) {
    for (let c = 0; c < 3; c++) image.data[4 * i + c] = bytes[3 * i + c] ?? 0;
    image.data[4 * i + 3] = 255;
  }
  e.getContext("2d")?.putImageData(image, 0, 0);
}

/**
 * Updates an SVG drawing. It is shown as an image, so that it cannot run scripts or load resources. Data that is not an
 * SVG is not shown.
 * @param {HTMLImageElement} e
 * @param {Values} v
 */
function updateSvg(e, v) {
  const namespace = "http://www.w3.org/2000/svg";
  const text = String(v.data ?? "");
  e.onerror = () => { e.style.display = "none"; };
  e.onload = () => { e.style.display = ""; };
  const svg = text.includes(namespace) ? text : text.replace(/<svg\b/, `<svg xmlns="${namespace}"`);
  if (text) e.src = `data:image/svg+xml,${encodeURIComponent(svg)}`;
  else {
    e.removeAttribute("src");
    e.style.display = "none";
  }
}

/**
 * Adds the tabs to a tab widget, and shows the current page.
 * @param {Values} values
 * @param {HTMLElement} node
 * @param {Report} report
 */
function addTabs(values, node, report) {
  const bar = make("div", { className: "tabs" });
  bar.setAttribute("role", "tablist");
  const pages = children(node);
  bar.append(...pages.map((p, i) => {
    const b = make("button", { textContent: p.dataset.title, onclick: () => { values.current = i; showTab(node, i); report("change", i); } });
    b.setAttribute("role", "tab");
    return b;
  }));
  node.prepend(bar);
  showTab(node, values.current ?? 0);
}

/** Returns the children of an element that are HTML elements. @param {HTMLElement} e */
function children(e) {
  return [...e.children].filter((c) => c instanceof HTMLElement);
}

/**
 * Shows a page of a tab widget.
 * @param {HTMLElement} node
 * @param {number} at index of the page
 */
function showTab(node, at) {
  const [bar, ...pages] = children(node);
  pages.forEach((p, i) => { p.hidden = i !== at; });
  [...(bar?.children ?? [])].forEach((b, i) => { b.setAttribute("aria-selected", String(i === at)); b.classList.toggle("on", i === at); });
}

/**
 * Creates the elements of all widgets of a window. Returns the element that contains them.
 * @param {WidgetWindow} window
 * @returns {HTMLElement}
 */
export function build(window) {
  window.widgets.forEach((widget, n) => {
    const { element, above, values } = widget;
    /** @type {Report} */
    const report = (what, value) => window.report(n, what, value);
    /** @type {HTMLElement} */
    let node;
    if (BOXES.has(element)) {
      node = make("div", { className: `box ${values.layout ?? "vbox"} ${values.flat ? "flat" : element}` });
      if (element === "tab") node.dataset.title = values.title ?? "";
    } else {
      const widgetKind = WIDGETS[element];
      node = widgetKind ? widgetKind.make(values, report) : make("div", { className: "rare", textContent: `<${element}>` });
      if (!["checkbox", "radiobutton"].includes(element)) node.setAttribute("aria-label", String(values.text ?? element));
    }
    window.elements[n] = node;
    if (above !== null && above !== undefined) window.elements[above]?.append(node);
  });
  window.widgets.forEach((widget, n) => {
    const node = window.elements[n];
    if (node && widget.element === "tabs") addTabs(widget.values, node, (what, value) => window.report(n, what, value));
    if (["grid", "form"].includes(widget.values.layout)) node?.style.setProperty("--columns", String(columns(window, n)));
    if (widget.values.layout === "cells") {
      const [wide, high] = widget.values.cells;
      node?.style.setProperty("--columns", String(wide));
      node?.style.setProperty("--rows", String(high));
    }
    if (n) refresh(window, n);
  });
  return window.elements[0] ?? make("div");
}

/**
 * Returns the number of columns of a grid, which is that of its longest row; 2 for a form.
 * @param {WidgetWindow} window
 * @param {number} n index of the widget that contains the grid
 */
function columns(window, n) {
  if (window.widgets[n]?.values.layout === "form") return 2;
  let [longest, current] = [1, 0];
  for (const w of window.widgets.filter((w) => w.above === n)) {
    current = w.element === "br" ? 0 : current + 1;
    longest = Math.max(longest, current);
  }
  return longest;
}

/**
 * Sets the cells that a widget occupies in a layout of cells, its colors and its alignment.
 * @param {HTMLElement} node
 * @param {Values} v
 */
function placeInCells(node, v) {
  const [x, y, wide, high] = v.cell;
  node.style.gridArea = `${y + 1} / ${x + 1} / span ${Math.max(high, 1)} / span ${Math.max(wide, 1)}`;
  node.style.color = v.color ?? "";
  node.style.background = v.background ?? "";
  node.classList.toggle("centered", v.centered === true);
  node.classList.toggle("clear", v.clear === true);
}

/**
 * Updates the element of a widget from the state of the widget.
 * @param {WidgetWindow} window
 * @param {number} n
 */
export function refresh(window, n) {
  const [widget, node] = [window.widgets[n], window.elements[n]];
  if (!widget || !node) return;
  const { element, values } = widget;
  node.hidden = values.visible === false;
  node.inert = values.enabled === false;
  if (element === "tabs" && values.current !== undefined) showTab(node, values.current);
  if (values.style) applyStyle(node, values.style);
  if (values.cell) placeInCells(node, values);
  WIDGETS[element]?.set(node, values, (what, value) => window.report(n, what, value));
}
