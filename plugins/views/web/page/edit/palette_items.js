// @ts-check
// The items of the palette, with their descriptions in the format of scene files. This module does not access the DOM.

import { mark } from "tatu/lib/language";
/**
 * An item of the palette, described by `toml`, or a model with the id `model`. `name` is that of the edit, `title` the one
 * shown in the palette, if it is another; `isRobot` is whether a model is expected to move by itself. `form` and `size` (m) are those of the
 * preview; `lift` is the height of the origin above the surface below, m; `attach` is whether the new object is
 * attached to the object below.
 * @typedef {{ name: string, title?: string, text: string, toml: string, model?: string, isRobot?: boolean, form: string, size: [number, number, number], lift: number, attach: boolean }} Item
 */
/** @typedef {{ name: string, items: Item[] }} Section */

/**
 * Returns a scene file with one object.
 * @param {string} alias
 * @param {string} keys the lines that describe the object
 */
function object(alias, keys) {
  return `format = 1\n[[object]]\nalias = "${alias}"\n${keys}\n`;
}

/**
 * Returns an item for a shape.
 * @param {string} name
 * @param {string} form
 * @param {[number, number, number]} size
 * @param {string} text
 * @param {boolean} [dynamic]
 * @returns {Item}
 */
function shape(name, form, size, text, dynamic = true) {
  const keys = `kind = "shape"\nprimitive = "${form}"\nsize_m = [${size.join(", ")}]\nrespondable = true${dynamic ? "\ndynamic = true" : ""}`;
  return { name, text, toml: object(name, keys), form, size, lift: size[2] / 2, attach: false };
}

/** @type {[number, number, number]} */
const SMALL = [0.05, 0.05, 0.05];

/**
 * Returns an item for another kind of object.
 * @param {string} name
 * @param {string} text
 * @param {string} keys
 * @param {Partial<Item>} [overrides]
 * @returns {Item}
 */
function otherItem(name, text, keys, overrides = {}) {
  return { name, text, toml: object(name, keys), form: "sphere", size: SMALL, lift: 0, attach: false, ...overrides };
}

/** @type {Section[]} */
export const FIXED = [
  {
    name: mark("Shapes"),
    items: [
      shape("box", "box", [0.2, 0.2, 0.2], mark("A box that falls and collides")),
      shape("sphere", "sphere", [0.2, 0.2, 0.2], mark("A ball that rolls")),
      shape("cylinder", "cylinder", [0.2, 0.2, 0.3], mark("A cylinder that stands upright")),
      shape("capsule", "capsule", [0.2, 0.2, 0.4], mark("A cylinder with round ends")),
      { ...shape("plane", "plane", [4, 4, 0.001], mark("An infinite floor that does not move"), false), toml: object("plane", 'kind = "shape"\nprimitive = "plane"\nrespondable = true'), lift: 0 },
      shape("wall", "box", [2, 0.1, 0.6], mark("A wall that does not move"), false),
    ],
  },
  {
    name: mark("Joints"),
    items: [
      otherItem("revolute", mark("Turns about its z axis; attach a shape to it"), 'kind = "joint"\ntype = "revolute"', { attach: true }),
      otherItem("prismatic", mark("Slides along its z axis; attach a shape to it"), 'kind = "joint"\ntype = "prismatic"\nlimits_m = [-0.5, 0.5]', { attach: true }),
    ],
  },
  {
    name: mark("Others"),
    items: [
      otherItem("dummy", mark("A frame: a point with an orientation"), 'kind = "dummy"'),
      otherItem("light", mark("A light for rendered images"), 'kind = "light"', { lift: 2 }),
      otherItem("camera", mark("A viewpoint for rendered images"), 'kind = "camera"', { lift: 1 }),
      otherItem("graph", mark("Records values over time"), 'kind = "graph"'),
    ],
  },
];

/**
 * Returns sections with items for the kinds of sensors, actuators and parts that `tatu.kinds` lists.
 * @param {{ object: string, id: string, text: string }[]} kinds
 * @returns {Section[]}
 */
export function devices(kinds) {
  const itemsOf = (/** @type {string} */ deviceKind) => kinds.filter((k) => k.object === deviceKind).map((k) => (
    otherItem(k.id, k.text, `kind = "${deviceKind}"\n${deviceKind} = "${k.id}"`, { attach: true })
  ));
  const sections = [
    { name: mark("Sensors"), items: itemsOf("sensor") },
    { name: mark("Actuators"), items: itemsOf("actuator") },
    { name: mark("Parts"), items: itemsOf("part") },
  ];
  return sections.filter((s) => s.items.length);
}

/** Sections of models in the order of the palette, by category. Those of other categories follow. */
const MODEL_SECTIONS = [
  "mobile robots", "arms", "grippers", "flying robots", "legged robots", "boats", "sensors", "machines", "furniture", "structures", "course items", "people",
];
/** Titles of sections of models that cannot be derived from the category. @type {{ [category: string]: string | undefined }} */
const SECTION_TITLES = { sensors: mark("Sensor models"), "": mark("Other models") };
/** Categories of models that are expected to move by themselves. */
const ROBOTS = /robots|arms|boats/;
/** Maximum length of a title that is taken from the description of a model, characters. */
const MAX_TITLE_LENGTH = 32;

/** Returns a text with its first letter in upper case. @param {string} text */
const capitalized = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/**
 * Returns the title of a model: the beginning of its description, as in "Thymio II, a robot for schools: two wheels", or
 * its id if the description does not begin with a name.
 * @param {string} id
 * @param {string} text
 */
export function titleOf(id, text) {
  const name = text.match(/^(\S.*?)(?: as in | after |, | with |: )/)?.[1] ?? "";
  const isName = name.length > 0 && name.length <= MAX_TITLE_LENGTH && !/^(an?|the) /i.test(name);
  return isName ? name.replaceAll("_", " ") : capitalized(id.replaceAll("_", " "));
}

/**
 * Returns sections with items for the models that `tatu.models` lists, one for each category.
 * @param {{ id: string, text: string, category?: string }[]} models
 * @returns {Section[]}
 */
export function models(models) {
  /** @type {Map<string, Item[]>} */
  const sections = new Map(MODEL_SECTIONS.map((category) => [category, []]));
  for (const { id, text, category = "" } of models) {
    const item = {
      ...otherItem(id, text, ""), title: titleOf(id, text), model: id, form: "box", size: /** @type {[number, number, number]} */ ([0.4, 0.4, 0.01]),
      attach: category === "sensors", isRobot: ROBOTS.test(category),
    };
    const items = sections.get(category);
    if (items) items.push(item);
    else sections.set(category, [item]);
  }
  // Models with the same description, such as those with an older and a newer name, are told apart by their ids.
  const all = [...sections.values()].flat();
  const repeated = all.filter((item) => all.some((other) => other !== item && other.title === item.title));
  for (const item of repeated) item.title += ` (${item.name})`;
  for (const items of sections.values()) items.sort((a, b) => (a.title ?? "").localeCompare(b.title ?? "", "en"));
  const filled = [...sections].filter(([, items]) => items.length);
  return filled.map(([category, items]) => ({ name: SECTION_TITLES[category] ?? capitalized(category), items }));
}
