// @ts-check
// Determines how properties are shown: their names, groups, units, values and types of fields, and the labels of edits.
// This module does not access the DOM, so it can be tested without a browser.

import { mark, t, translate } from "tatu/lib/language";
/** @import { PropertyRow } from "tatu/protocol" */

/** Names of the groups in display order. Further groups, such as that of a light, are shown after the first one. */
export const GROUPS = [
  mark("Place"), mark("Shape"), mark("Physics"), mark("Joint"), mark("Sensor"), mark("Drive"), mark("Reading"), mark("Script"), mark("More"),
];

/** Display names that cannot be derived from the key. @type {{ [key: string]: string | undefined }} */
const NAMES = {
  "object.alias": t`Name`, "object.name": t`Unique name`, "object.orientation": t`Orientation`, "object.world_pose": t`Pose in the world`,
  "object.model_base": t`Base of a model`, "object.drive": t`Drive by wheels`, "shape.primitive": t`Form`, "shape.com": t`Centre of mass`,
  "shape.dynamic": t`Moved by forces`, "shape.respondable": t`Collides`, "shape.respondable_mask": t`Collision mask`,
  "shape.detectable": t`Seen by sensors`, "shape.detectable_mask": t`Detection mask`, "shape.convex": t`Convex hull`, "shape.bullet": t`Fast body`,
  "shape.asleep": t`Starts asleep`,
  "shape.collide_as": t`Collides as`, "shape.collide_size": t`Size for collisions`, "joint.mode": t`Moved by`, "joint.effort": t`Torque or force`,
  "joint.max_force": t`Maximum force`, "joint.lead": t`Lead of the screw`, "joint.slip": t`Slip under load`, "joint.cyclic": t`Turns without limit`,
  "sensor.explicit": t`Only on request`, "sensor.targets": t`Sees only`, "sensor.ignored": t`Does not see`, "sensor.measured": t`Measurements`, "actuator.targets": t`Acts on`,
  "graph.explicit": t`Only on request`, "camera.ortho_size": t`Width of a parallel view`, "camera.near": t`Nearest distance`,
  "camera.far": t`Farthest distance`, "force_sensor.measured": t`Has measured`,
};
/** Words that replace abbreviations in keys. @type {{ [part: string]: string | undefined }} */
const WORDS = { max: "maximum", min: "minimum", num: "number of", vel: "velocity", pos: "position" };

/**
 * Returns the display name of a property, such as "Maximum force" for `joint.max_force`.
 * @param {string} key
 */
export function nameOf(key) {
  const special = NAMES[key];
  if (special) return special;
  const words = key.slice(key.lastIndexOf(".") + 1).split("_").map((part) => WORDS[part] ?? part).join(" ");
  return translate(words.charAt(0).toUpperCase() + words.slice(1));
}

const PLACE_KEYS = ["alias", "parent", "position", "orientation", "visible"];
const SHAPE_KEYS = ["primitive", "size", "color", "opacity", "texture", "convex", "detectable", "material"];
/** Keys of properties that are rarely set, and are shown in the group "More". */
const ADVANCED_KEYS = [
  "shape.mesh", "shape.respondable_mask", "shape.detectable_mask", "shape.joint_solver", "shape.bullet", "shape.asleep", "shape.friction_axis",
  "shape.friction_axis_angle", "shape.axis_friction", "shape.surface_velocity", "shape.initial_velocity", "shape.initial_angular_velocity",
  "shape.linear_damping", "shape.angular_damping", "shape.collide_as", "shape.collide_size", "joint.rotation", "joint.armature", "joint.slip", "joint.lead",
  "joint.smooth_target", "joint.no_load_speed", "joint.follows", "joint.follow_factor", "joint.follow_offset", "joint.follow_curve",
  "joint.geared", "sensor.beams",
];

/**
 * Returns the name of the group in which a property is shown.
 * @param {string} key
 * @param {string} kind the kind of the object
 */
export function groupOf(key, kind) {
  const dot = key.indexOf(".");
  if (dot < 0) return "Reading";
  const [owner, short] = [key.slice(0, dot), key.slice(dot + 1)];
  if (ADVANCED_KEYS.includes(key)) return "More";
  if (key === "object.drive") return "Drive";
  if (owner === "object") return PLACE_KEYS.includes(short) ? "Place" : "More";
  if (owner === "shape") return SHAPE_KEYS.includes(short) ? "Shape" : "Physics";
  if (owner === "force_sensor") return "Sensor";
  if (["joint", "sensor", "script"].includes(owner)) return title(owner);
  if (kind === "actuator" || kind === "part") return "Drive";
  return kind === "sensor" ? "Sensor" : title(owner);
}

/** @param {string} word */
function title(word) {
  return word.charAt(0).toUpperCase() + word.slice(1).replaceAll("_", " ");
}

const DEGREE = 180 / Math.PI;

/**
 * Returns the unit in which values are shown, and the factor by which they are multiplied: rad is shown as degrees. In
 * units such as `rad|m`, the second unit applies to prismatic joints.
 * @param {string} unit
 * @param {boolean} [slides] whether the object is a prismatic joint
 */
export function unitOf(unit, slides = false) {
  const [turning = "", sliding] = unit.split("|");
  const one = slides && sliding !== undefined ? sliding : turning;
  if (one === "rad") return { text: "\u00b0", factor: DEGREE };
  if (one === "rad/s") return { text: "\u00b0/s", factor: DEGREE };
  return { text: one, factor: 1 };
}

/**
 * Encodes a number as an argument of a command. Infinite numbers become objects, because JSON cannot represent them.
 * @param {number} x
 */
export function encodeNumber(x) {
  if (Number.isFinite(x)) return x;
  return { number: x > 0 ? "inf" : "-inf" };
}

/**
 * Returns the labels for the elements of a property with several elements, such as x, y and z.
 * @param {string} key
 * @param {number} count
 * @returns {string[]}
 */
export function partNames(key, count) {
  if (key === "joint.limits") return [t`from`, t`to`];
  if (key === "joint.gains") return ["P", "I", "D"].slice(0, count);
  if (count === 2 || count === 3) return ["x", "y", "z"].slice(0, count);
  if (count === 4 && /quaternion|rotation$/.test(key)) return ["x", "y", "z", "w"];
  return Array.from({ length: count }, (_, i) => String(i + 1));
}

/** @type {{ [key: string]: string | undefined }} */
const VERBS = { "object.position": t`Move`, "object.pose": t`Move`, "object.world_pose": t`Move`, "object.orientation": t`Turn`, "object.quaternion": t`Turn`, "object.alias": t`Rename` };

/**
 * Returns the label of an edit that sets a property, such as "Move box".
 * @param {string} key
 * @param {string} alias name of the object
 */
export function labelOf(key, alias) {
  const verb = VERBS[key];
  const name = nameOf(key);
  return verb ? `${verb} ${alias}` : t`Set ${name.charAt(0).toLowerCase() + name.slice(1)} of ${alias}`;
}

/**
 * Converts red, green and blue components, 0 to 1, to a hexadecimal CSS color.
 * @param {number[]} color
 */
export function hexOf(color) {
  return `#${color.slice(0, 3).map((x) => Math.round(255 * Math.min(1, Math.max(0, x))).toString(16).padStart(2, "0")).join("")}`;
}

/** Converts a hexadecimal CSS color to red, green and blue components, 0 to 1. @param {string} hex */
export function colorOf(hex) {
  return [1, 3, 5].map((i) => Number((parseInt(hex.slice(i, i + 2), 16) / 255).toFixed(4)));
}

/** Types of values: the constants `TATU_*` of the plugin interface. */
export const TYPE = { bool: 1, integer: 2, float: 3, text: 4, floats: 6, integers: 8, list: 11, map: 12, object: 14 };

/**
 * Returns the type of field that shows a property.
 * @param {PropertyRow} row
 * @returns {"check" | "choice" | "color" | "object" | "parts" | "number" | "numbers" | "texts" | "text" | "table"}
 */
export function formOf({ type, count, key, choices, value }) {
  if (type === TYPE.object) return "object";
  if (type === TYPE.bool || typeof value === "boolean") return "check";
  if (choices.length) return "choice";
  if (type === TYPE.integer || type === TYPE.float) return "number";
  if (Array.isArray(value) && (type === TYPE.floats || type === TYPE.integers)) {
    if (value.length === 3 && /(^|[._])color$/.test(key)) return "color";
    const n = count || (value.length <= 4 ? value.length : 0);
    return n >= 2 && n <= 4 ? "parts" : "numbers";
  }
  if (type === TYPE.list && Array.isArray(value) && value.every((v) => typeof v === "string")) return "texts";
  return typeof value === "object" && value !== null ? "table" : "text";
}
