// @ts-check
// The icons of the page: paths on a 24 x 24 grid, stroked or filled in the color of the text.

const FILLED = new Set(["play", "pause", "step", "stop"]);
/** @type {{ [name: string]: string }} */
const PATHS = {
  new: "M6 3h8l4 4v14H6zM14 3v4h4M12 11v6M9 14h6",
  open: "M3 6h6l2 2h10v11H3z",
  save: "M4 4h13l3 3v13H4zM8 4v5h8V4M8 20v-6h8v6",
  "save-as": "M13 20H4V4h13l3 3v4M8 4v5h8V4M15 20l6-6M21 14l-1.5-1.500L14 18v2z",
  undo: "M8 4L4 8l4 4M4 8h10a5.5 5.5 0 0 1 0 11H9",
  redo: "M16 4l4 4-4 4M20 8H10a5.5 5.5 0 0 0 0 11h5",
  add: "M12 5v14M5 12h14",
  play: "M7 4v16l13-8z",
  pause: "M6 4h4v16H6zM14 4h4v16h-4z",
  step: "M5 4v16l10-8zM17 4h3v16h-3z",
  stop: "M5 5h14v14H5z",
  slower: "M11 6l-6 6 6 6M19 6l-6 6 6 6",
  faster: "M5 6l6 6-6 6M13 6l6 6-6 6",
  select: "M4 8V4h4M16 4h4v4M20 16v4h-4M8 20H4v-4M11 12h2",
  move: "M12 3v18M3 12h18M9 6l3-3 3 3M9 18l3 3 3-3M6 9l-3 3 3 3M18 9l3 3-3 3",
  guide: "M3 21h7M6.500 21v-6l5-7 7 2M11.500 8a1.200 1.200 0 1 0-.1 0M6.500 15a1.200 1.200 0 1 0-.1 0M18.500 10l2.500-2.500M18.500 10l2 3",
  turn: "M20 12a8 8 0 1 1-2.4-5.700M18 2v5h-5",
  orbit: "M12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6zM4 14c-4-5 13-9 16-4 2 4-7 7-12 7M10 14l-2.5 3 3 2.5",
  pan: "M8 12V6.500a1.500 1.500 0 0 1 3 0V11M11 11V5a1.500 1.500 0 0 1 3 0v6M14 11V6a1.500 1.500 0 0 1 3 0v8c0 4-2 7-6 7-3 0-4-2-6.500-6 -1-2 1-3 2-1.500L8 15",
  zoom: "M10 4a6 6 0 1 0 0 12 6 6 0 0 0 0-12zM14.500 14.500L20 20M7.500 10h5M10 7.500v5",
  fit: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5M9 9h6v6H9z",
  follow: "M12 2v5M12 17v5M2 12h5M17 12h5M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8z",
  flat: "M4 8h11v12H4zM4 8l5-4h11l-5 4M20 4v12l-5 4",
  overlays: "M12 3l9 5-9 5-9-5zM4 12l8 4.5 8-4.500M4 16l8 4.5 8-4.5",
  windows: "M3 5h12v9H3zM9 14v5h12v-9h-6M3 8h12",
  exercise: "M5 3h14v18H5zM8 8l1.5 1.500L12 7M8 14l1.5 1.500L12 13M14 9h3M14 15h3",
  film: "M3 5h18v14H3zM7 5v14M17 5v14M3 9h4M3 15h4M17 9h4M17 15h4",
  tree: "M4 5h6M8 12h6M8 19h6M5 5v14h3M5 12h3M17 5h3M17 12h3M17 19h3",
  details: "M4 7h8M16 7h4M14 5v4M4 17h4M12 17h8M10 15v4",
  more: "M5 12h.01M12 12h.01M19 12h.01",
  up: "M5 15l7-7 7 7",
  down: "M5 9l7 7 7-7",
  shape: "M12 3l8 4.500v9L12 21l-8-4.500v-9zM12 12l8-4.500M12 12L4 7.500M12 12v9",
  joint: "M4 20l5.2-5.200M14.8 9.200L20 4M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8z",
  dummy: "M12 13V3M12 13l8 5M12 13l-8 5",
  sensor: "M5 12h.01M9 8a6 6 0 0 1 0 8M13 5a10 10 0 0 1 0 14M17 2.500a14 14 0 0 1 0 19",
  actuator: "M12 12h.01M12 9C7 2 3 7 9 11M12 15c5 7 9 2 3-2",
  part: "M8 8h8v8H8zM5 10h3M5 14h3M16 10h3M16 14h3",
  force_sensor: "M12 3v10M8 9l4 4 4-4M5 17h14M5 21h14",
  camera: "M3 7h11v10H3zM14 11l7-4v10l-7-4",
  light: "M9 18h6M10 21h4M9 18c0-3-3-4-3-8a6 6 0 0 1 12 0c0 4-3 5-3 8",
  graph: "M4 4v16h16M7 15l4-5 3 3 5-7",
  path: "M3 18c5 0 4-12 9-12s4 12 9 12",
  model: "M5 9h14v9H5zM12 9V5M9 13h.01M15 13h.01M8 18v3M16 18v3",
  script: "M8 7l-5 5 5 5M16 7l5 5-5 5M14 4l-4 16",
};
const SVG = "http://www.w3.org/2000/svg";

/**
 * Creates an icon. It is empty if there is no icon with this name.
 * @param {string} name
 */
export function icon(name) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  svg.classList.add("icon");
  if (FILLED.has(name)) svg.classList.add("filled");
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("d", PATHS[name] ?? "");
  svg.append(path);
  return svg;
}

for (const element of document.querySelectorAll("[data-icon]")) element.prepend(icon(element.getAttribute("data-icon") ?? ""));
