// The widgets of windows that scripts open: each is built once and brought up to date when the script changes it.

import { plot } from "tatu/plot";
import { fill, restyle } from "tatu/rich";

const make = (tag, more = {}) => Object.assign(document.createElement(tag), more);

function range(v, type) {
  const input = make("input", { type, min: v.minimum ?? 0, max: v.maximum ?? 100, step: v.step ?? 1, value: v.value ?? 0 });
  if (type === "number" && v.float) input.step = v.step && v.step !== 1 ? v.step : "any";
  return input;
}

/** Elements by name: `make` builds one, `set` shows what it holds. `tell` says what was done. */
const WIDGETS = {
  label: {
    make: () => make("div", { className: "label" }),
    set: (e, v, tell) => fill(e, v.text, (link) => tell("link", link)),
  },
  "text-browser": { make: () => make("div", { className: "text" }), set: (e, v, tell) => fill(e, v.text, (link) => tell("link", link)) },
  button: {
    make: (v, tell) => make("button", { onclick: () => tell("click") }),
    set: (e, v) => {
      e.textContent = v.text ?? "";
      if (v.checkable) e.setAttribute("aria-pressed", String(v.checked === true));
    },
  },
  hslider: { make: (v, tell) => slider(v, tell), set: (e, v) => number(e, v) },
  vslider: { make: (v, tell) => Object.assign(slider(v, tell), { className: "upright" }), set: (e, v) => number(e, v) },
  spinbox: {
    make: (v, tell) => {
      const input = range(v, "number");
      input.onchange = () => tell("change", Number(input.value));
      return input;
    },
    set: (e, v) => number(e, v),
  },
  edit: {
    make: (v, tell) => {
      const input = make("input", { type: "text" });
      input.onchange = () => tell("change", input.value);
      return input;
    },
    set: (e, v) => { if (e !== document.activeElement) e.value = v.value ?? ""; },
  },
  checkbox: { make: (v, tell) => tick("checkbox", v, (on) => tell("change", on)), set: ticked },
  radiobutton: { make: (v, tell) => tick("radio", v, () => tell("click")), set: ticked },
  progressbar: {
    make: () => make("progress"),
    set: (e, v) => {
      e.max = (v.maximum ?? 100) - (v.minimum ?? 0) || 1;
      e.value = (v.value ?? 0) - (v.minimum ?? 0);
    },
  },
  combobox: {
    make: (v, tell) => {
      const list = make("select");
      list.onchange = () => tell("change", list.selectedIndex);
      return list;
    },
    set: (e, v) => {
      e.replaceChildren(...(v.items ?? []).map((text) => new Option(text)));
      e.selectedIndex = v.index ?? 0;
    },
  },
  table: {
    make: () => make("table"),
    set: (e, v) => {
      const row = (cells, tag) => {
        const tr = make("tr");
        tr.append(...cells.map((text) => make(tag, { textContent: text })));
        return tr;
      };
      e.replaceChildren(...(v.headers?.length ? [row(v.headers, "th")] : []), ...(v.rows ?? []).map((r) => row(r, "td")));
    },
  },
  tree: {
    make: () => make("ul", { className: "items" }),
    set: (e, v, tell) => {
      const below = (id) => (v.rows ?? []).filter((r) => (r.above ?? 0) === id).map((r) => {
        const li = make("li");
        const b = make("button", { textContent: r.texts.join("  "), onclick: () => tell("select", r.id) });
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
  image: { make: () => make("canvas", { width: 1, height: 1 }), set: paint },
  svg: { make: () => make("img", { alt: "" }), set: draw },
  plot: {
    make: () => make("canvas", { width: 320, height: 200 }),
    set: (e, v) => plot(e, (v.curves ?? []).map((c) => ({
      name: c.name, color: (c.color ?? [200, 0, 0]).map((x) => x / 255), times: c.x, values: c.y,
    })), (v.curves ?? []).every((c) => c.kind === 0) ? "s" : ""),
  },
  br: { make: () => make("span", { className: "br" }), set: () => {} },
  stretch: { make: () => make("span", { className: "stretch" }), set: () => {} },
};
/** Those that hold others. */
const BOXES = new Set(["ui", "group", "tabs", "tab"]);

function slider(v, tell) {
  const input = range(v, "range");
  input.oninput = () => tell("change", Number(input.value));
  return input;
}

function number(e, v) {
  Object.assign(e, { min: v.minimum ?? 0, max: v.maximum ?? 100 });
  if (e !== document.activeElement) e.value = v.value ?? 0;
}

function tick(type, v, tell) {
  const label = make("label");
  const input = make("input", { type });
  input.onchange = () => tell(input.checked);
  label.append(input, make("span"));
  return label;
}

function ticked(e, v) {
  const [input, text] = e.children;
  input.checked = v.checked > 0;
  input.indeterminate = v.checked === 1 && input.type === "checkbox";
  fill(text, v.text);
}

/** An image, the upper row first. */
function paint(e, v) {
  const [w, h] = [v.columns, v.rows];
  if (!v.pixels?.bytes || !(w > 0 && h > 0)) return;
  const bytes = Uint8Array.from(atob(v.pixels.bytes), (c) => c.charCodeAt(0));
  Object.assign(e, { width: w, height: h });
  const image = new ImageData(w, h);
  for (let i = 0; i < w * h; i++) {
    for (let c = 0; c < 3; c++) image.data[4 * i + c] = bytes[3 * i + c];
    image.data[4 * i + 3] = 255;
  }
  e.getContext("2d").putImageData(image, 0, 0);
}

/** A drawing: as an image, so that nothing in it runs or loads. What is none is not shown. */
function draw(e, v) {
  const named = "http://www.w3.org/2000/svg";
  const text = String(v.data ?? "");
  e.onerror = () => { e.style.display = "none"; };
  e.onload = () => { e.style.display = ""; };
  const whole = text.includes(named) ? text : text.replace(/<svg\b/, `<svg xmlns="${named}"`);
  if (text) e.src = `data:image/svg+xml,${encodeURIComponent(whole)}`;
  else {
    e.removeAttribute("src");
    e.style.display = "none";
  }
}

/** A tab shows one of its pages. */
function tabs(window, n, made, tell) {
  const { values } = window.widgets[n];
  const bar = make("div", { className: "tabs" });
  bar.setAttribute("role", "tablist");
  const pages = [...made.children];
  bar.append(...pages.map((p, i) => {
    const b = make("button", { textContent: p.dataset.title, onclick: () => { values.current = i; front(made, i); tell("change", i); } });
    b.setAttribute("role", "tab");
    return b;
  }));
  made.prepend(bar);
  front(made, values.current ?? 0);
}

function front(made, at) {
  const [bar, ...pages] = made.children;
  pages.forEach((p, i) => { p.hidden = i !== at; });
  [...bar.children].forEach((b, i) => { b.setAttribute("aria-selected", String(i === at)); b.classList.toggle("on", i === at); });
}

/** Builds all widgets of a window; the box that holds them. `act(n, what, value)` says what was done. */
export function build(window, act) {
  window.act_on = act;
  window.widgets.forEach((widget, n) => {
    const { element, above, values } = widget;
    const tell = (what, value) => act(n, what, value);
    let made;
    if (BOXES.has(element)) {
      made = make("div", { className: `box ${values.layout ?? "vbox"} ${values.flat ? "flat" : element}` });
      if (element === "tab") made.dataset.title = values.title ?? "";
    } else {
      const known = WIDGETS[element];
      made = known ? known.make(values, tell) : make("div", { className: "rare", textContent: `<${element}>` });
      if (!["checkbox", "radiobutton"].includes(element)) made.setAttribute("aria-label", String(values.text ?? element));
    }
    window.made[n] = made;
    if (above !== null && above !== undefined) window.made[above]?.append(made);
  });
  // What stands in a grid is in columns: as many as its longest row has.
  window.widgets.forEach((widget, n) => {
    if (widget.element === "tabs") tabs(window, n, window.made[n], (what, value) => act(n, what, value));
    if (["grid", "form"].includes(widget.values.layout)) window.made[n].style.setProperty("--columns", columns(window, n));
    if (n) refresh(window, n);
  });
  return window.made[0];
}

function columns(window, n) {
  if (window.widgets[n].values.layout === "form") return 2;
  let [most, now] = [1, 0];
  for (const w of window.widgets.filter((w) => w.above === n)) {
    now = w.element === "br" ? 0 : now + 1;
    most = Math.max(most, now);
  }
  return most;
}

/** Shows what a widget holds now. */
export function refresh(window, n) {
  const { element, values } = window.widgets[n];
  const made = window.made[n];
  made.hidden = values.visible === false;
  made.inert = values.enabled === false;
  if (element === "tabs" && values.current !== undefined) front(made, values.current);
  if (values.style) restyle(made, values.style);
  WIDGETS[element]?.set(made, values, (what, value) => window.act_on(n, what, value));
}
