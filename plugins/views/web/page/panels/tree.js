// @ts-check
// The tree of objects. A click selects an object, and clicks with Ctrl or Shift select several; a double click opens
// the first script of the object.

import { get } from "tatu/lib/dom";
import { icon } from "tatu/lib/icons";
import { t } from "tatu/lib/language";
import { nameInModel } from "tatu/scene/hierarchy";
import { scene, select, selectAll, selected, selection, watch } from "tatu/scene/store";
import { openScript } from "tatu/documents/script_editor";

/** @import { SceneObject } from "tatu/protocol" */

const tree = get("tree");
const search = get("search", HTMLInputElement);
/** Handles of the collapsed objects. @type {Set<number>} */
const collapsed = new Set();
/** Handles of the objects that were in the scene before. @type {Set<number>} */
const known = new Set();
/** The displayed rows, by the handle of the object. @type {Map<number, HTMLElement>} */
let items = new Map();

/**
 * Creates a button with an icon.
 * @param {string} iconName name of the icon
 * @param {string} title
 * @param {() => void} f
 */
function button(iconName, title, f) {
  const b = document.createElement("button");
  b.className = "tool";
  b.append(icon(iconName));
  b.title = title;
  b.setAttribute("aria-label", title);
  b.onclick = (e) => { e.stopPropagation(); f(); };
  return b;
}

/**
 * Creates the item of an object, with those of its children.
 * @param {SceneObject} object
 * @param {HTMLElement[]} children
 */
function item(object, children) {
  const li = document.createElement("li");
  li.setAttribute("role", "none");
  const row = document.createElement("div");
  row.className = "item";
  row.setAttribute("role", "treeitem");
  row.dataset.id = String(object.id);
  row.id = `object-${object.id}`;
  const arrow = document.createElement("span");
  arrow.className = "twist";
  // A search shows what it has found, also in collapsed objects.
  const isOpen = !collapsed.has(object.id) || search.value.trim() !== "";
  arrow.textContent = children.length ? (isOpen ? "\u25BE" : "\u25B8") : "";
  arrow.onclick = (e) => {
    e.stopPropagation();
    if (!collapsed.delete(object.id)) collapsed.add(object.id);
    draw();
  };
  if (children.length) row.setAttribute("aria-expanded", String(isOpen));
  const kind = document.createElement("span");
  kind.className = "kind";
  kind.append(icon(object.model ? "model" : object.kind));
  kind.title = object.sensor ?? object.kind;
  const name = document.createElement("span");
  name.className = "alias";
  name.textContent = nameInModel(object);
  name.title = object.alias;
  row.append(arrow, kind, name);
  for (const script of object.scripts ?? []) {
    row.append(button("script", t`Script ${script.name}`, () => openScript(script)));
  }
  row.onclick = (e) => click(object.id, e);
  row.ondblclick = () => { const [script] = object.scripts ?? []; if (script) openScript(script); };
  items.set(object.id, row);
  li.append(row);
  if (children.length && isOpen) {
    const ul = document.createElement("ul");
    ul.setAttribute("role", "group");
    ul.append(...children);
    li.append(ul);
  }
  return li;
}

/** Returns the handles of the displayed objects, from top to bottom. */
function shownIds() {
  return [...tree.querySelectorAll("[data-id]")].map((row) => Number(/** @type {HTMLElement} */ (row).dataset.id));
}

/**
 * Selects an object, or several with Ctrl or Shift.
 * @param {number} id
 * @param {MouseEvent} e
 */
function click(id, e) {
  if (e.ctrlKey || e.metaKey) select(id, true);
  else if (e.shiftKey && selected()) {
    const all = shownIds();
    const [a, b] = [all.indexOf(selected()), all.indexOf(id)].sort((x, y) => x - y);
    selectAll([...all.slice(a, (b ?? 0) + 1).filter((other) => other !== id), id]);
  } else select(id);
}

/**
 * Returns the row of an object, or undefined if it is not displayed.
 * @param {number} id
 */
export function rowOf(id) {
  return items.get(id);
}

/** Builds the tree again. */
function draw() {
  /** @type {Map<number, SceneObject[]>} */
  const childrenOf = new Map();
  for (const o of scene.objects.values()) {
    const siblings = childrenOf.get(o.parent);
    if (siblings) siblings.push(o);
    else childrenOf.set(o.parent, [o]);
  }
  const filter = search.value.trim().toLowerCase();
  items = new Map();
  /** @returns {HTMLElement | null} */
  const build = (/** @type {SceneObject} */ o) => {
    const children = (childrenOf.get(o.id) ?? []).map(build).filter((c) => c !== null);
    const isShown = !filter || o.alias.toLowerCase().includes(filter) || children.length;
    return isShown ? item(o, children) : null;
  };
  const roots = (childrenOf.get(0) ?? []).map(build).filter((c) => c !== null);
  for (const script of scene.scripts) {
    const li = document.createElement("li");
    const row = document.createElement("div");
    row.className = "item";
    row.append(button("script", script.name, () => openScript(script)), `${script.kind}: ${script.name}`);
    row.ondblclick = () => openScript(script);
    li.append(row);
    roots.unshift(li);
  }
  tree.replaceChildren(...roots);
  markSelected();
}

/** Marks the rows of the selected objects. */
function markSelected() {
  const ids = new Set(selection());
  for (const [id, row] of items) row.setAttribute("aria-selected", String(ids.has(id)));
  // A screen reader announces this row while the tree has the focus.
  const activeRow = items.get(selected());
  if (activeRow) tree.setAttribute("aria-activedescendant", activeRow.id);
  else tree.removeAttribute("aria-activedescendant");
  items.get(selected())?.scrollIntoView({ block: "nearest" });
}

tree.addEventListener("keydown", (e) => {
  if (e.target !== tree) return;
  const all = shownIds();
  const at = all.indexOf(selected());
  if (e.key === "ArrowDown") select(all[Math.min(at + 1, all.length - 1)] ?? 0);
  else if (e.key === "ArrowUp") select(all[Math.max(at - 1, 0)] ?? 0);
  else if (e.key === "ArrowLeft") { collapsed.add(selected()); draw(); }
  else if (e.key === "ArrowRight") { collapsed.delete(selected()); draw(); }
  else if (e.key === "Enter") {
    const script = scene.objects.get(selected())?.scripts?.[0];
    if (script) openScript(script);
  } else return;
  e.preventDefault();
});
search.oninput = draw;
watch("scene", () => {
  // Models are collapsed at first, because users usually look for the base of a model.
  if (scene.isNew) {
    collapsed.clear();
    known.clear();
  }
  for (const o of scene.objects.values()) {
    if (o.model && !known.has(o.id)) collapsed.add(o.id);
    known.add(o.id);
  }
  unfoldIfMoved();
  draw();
});
watch("objects", () => {
  // The tree is not rebuilt while an object is being renamed, because that would remove the input field.
  if (tree.querySelector("input")) return;
  unfoldIfMoved();
  draw();
});
watch("selected", () => {
  if (unfold()) draw();
  markSelected();
});

/** The parent of the selected object when the tree was unfolded to it. */
let parentOfSelected = 0;
/** Unfolds the tree to the selected object. Returns whether an object was folded. */
function unfold() {
  let up = parentOfSelected = scene.objects.get(selected())?.parent ?? 0;
  let opened = false;
  while (up) {
    opened = collapsed.delete(up) || opened;
    up = scene.objects.get(up)?.parent ?? 0;
  }
  return opened;
}

/** Unfolds the tree to the selected object if its parent has changed: a new sensor is attached to a robot after it was added. */
function unfoldIfMoved() {
  if ((scene.objects.get(selected())?.parent ?? 0) !== parentOfSelected) unfold();
}
