// The status bar, and a tab for each console that scripts open.

import { on } from "tatu/net";

const MOST = 1000;
const tabs = document.getElementById("tabs");
const output = document.getElementById("output");
const pages = new Map();
let open = "Status";

function page(name) {
  if (!pages.has(name)) {
    pages.set(name, []);
    const b = document.createElement("button");
    b.textContent = name;
    b.setAttribute("role", "tab");
    b.onclick = () => show(name);
    tabs.append(b);
    mark();
  }
  return pages.get(name);
}

function mark() {
  for (const b of tabs.children) {
    b.setAttribute("aria-selected", String(b.textContent === open));
    b.classList.toggle("on", b.textContent === open);
  }
}

function show(name) {
  open = name;
  mark();
  output.replaceChildren(...page(name));
  output.scrollTop = output.scrollHeight;
}

/** Empties all pages. */
export function clear() {
  for (const name of pages.keys()) pages.set(name, []);
  show(open);
}

/** Writes a line. */
export function line(name, text, level = "") {
  const div = document.createElement("div");
  div.className = level;
  div.textContent = text;
  const all = page(name);
  all.push(div);
  const bottom = output.scrollTop + output.clientHeight >= output.scrollHeight - 8;
  if (all.length > MOST) all.shift().remove();
  if (name === open) {
    output.append(div);
    if (bottom) output.scrollTop = output.scrollHeight;
  }
}

on("event", ({ event, payload }) => {
  if (event === "message") line("Status", payload.text, payload.level);
  else if (event === "console") {
    if (payload.clear) pages.set(payload.title, []);
    else line(payload.title, payload.text);
    if (open === payload.title) show(open);
  }
  else if (event === "started") line("Status", "simulation started");
  else if (event === "stopped") line("Status", "simulation stopped: the scene is as it was");
});
on("again", clear);
on("error", ({ error, help }) => line("Status", help ? `${error} (${help})` : error, "error"));
page("Status");
