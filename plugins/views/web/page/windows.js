// Windows that scripts open, with their widgets; what is done to them goes back to the script.

import { call, on } from "tatu/net";
import { line } from "tatu/output";
import { rights } from "tatu/store";
import { build, refresh } from "tatu/widgets";

const host = document.getElementById("view");
const open = new Map();

/** Tells the script what was done. */
async function act(window, n, what, value) {
  if (!rights.acts) return;
  try {
    await call(window.act, window.window, n, what, ...(value === undefined ? [] : [value]));
  } catch (e) {
    line("Status", e.error, "error");
  }
}

/** Lets a window be moved by its title. */
function drag(box, bar) {
  bar.onpointerdown = (e) => {
    if (e.target !== bar) return;
    const [x, y] = [e.clientX - box.offsetLeft, e.clientY - box.offsetTop];
    bar.setPointerCapture(e.pointerId);
    bar.onpointermove = (m) => {
      box.style.left = `${Math.max(0, Math.min(m.clientX - x, host.clientWidth - 60))}px`;
      box.style.top = `${Math.max(0, Math.min(m.clientY - y, host.clientHeight - 30))}px`;
    };
    bar.onpointerup = () => { bar.onpointermove = null; };
  };
}

/** What a window as a whole holds. */
function place(window) {
  const { box, title, widgets: [{ values }] } = window;
  title.textContent = values.title ?? "";
  box.hidden = values.visible === false;
  box.inert = values.enabled === false || !rights.acts;
  box.setAttribute("aria-label", values.title || "window of a script");
  if (values.width > 0) box.style.width = `${values.width}px`;
  if (values.height > 0) box.style.height = `${values.height}px`;
  if (Number.isFinite(values.x)) box.style.left = `${values.x}px`;
  if (Number.isFinite(values.y)) box.style.top = `${values.y}px`;
}

function show(key, payload) {
  open.get(key)?.box.remove();
  const box = document.createElement("section");
  box.className = "window";
  box.style.left = `${16 + 24 * (open.size % 8)}px`;
  box.style.top = `${16 + 24 * (open.size % 8)}px`;
  const bar = document.createElement("div");
  bar.className = "title";
  const title = document.createElement("span");
  bar.append(title);
  const window = { ...payload, box, title, made: [] };
  if (payload.widgets[0].values.closeable) {
    const close = document.createElement("button");
    close.textContent = "\u00D7";
    close.setAttribute("aria-label", "Close this window");
    close.onclick = () => act(window, 0, "close");
    bar.append(close);
  }
  // Keys and clicks in a window are not for the view behind it.
  for (const kind of ["keydown", "pointerdown", "pointerup", "wheel"]) box.addEventListener(kind, (e) => e.stopPropagation());
  box.append(bar, build(window, (n, what, value) => act(window, n, what, value)));
  drag(box, bar);
  open.set(key, window);
  place(window);
  host.append(box);
}

function closeAll() {
  for (const { box } of open.values()) box.remove();
  open.clear();
}

// The program opens again those that are still there.
on("again", closeAll);
on("event", ({ event, payload }) => {
  if (event === "stopped") closeAll();
  if (event !== "ui.window") return;
  const key = `${payload.act} ${payload.window}`;
  if (payload.widgets) return show(key, payload);
  const window = open.get(key);
  if (!window) return;
  if (payload.closed) {
    window.box.remove();
    open.delete(key);
    return;
  }
  Object.assign(window.widgets[payload.n].values, payload.set);
  if (payload.n === 0) place(window);
  else refresh(window, payload.n);
});
