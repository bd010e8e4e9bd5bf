// @ts-check
// Reads joints, and builds the calls that move them.

import { call } from "tatu/net/connection";
import { editState } from "tatu/scene/edits";

/** @import { Call } from "tatu/scene/edits" */

/**
 * Returns a promise of a joint property, or of null if the property cannot be read.
 * @param {number} id
 * @param {string} key
 */
export async function readJoint(id, key) {
  return call("tatu.get", id, `joint.${key}`).then(([value]) => value, () => null);
}

/**
 * Returns whether position control moves a joint.
 * @param {number} id
 */
async function isPositionControlled(id) {
  const [mode, control] = await Promise.all([readJoint(id, "mode"), readJoint(id, "control")]);
  return mode === "dynamic" && control === "position";
}

/**
 * Returns the command calls that move a joint to a position. For a joint under position control, they set the target;
 * if the simulation is stopped, they set the position as well, so that the joint does not move when the simulation
 * starts.
 * @param {number} id
 * @param {number} to rad or m
 * @returns {Promise<Call[]>}
 */
export async function callsToMoveJoint(id, to) {
  const isDriven = await isPositionControlled(id);
  /** @type {Call[]} */
  const calls = [];
  if (!isDriven || editState.state === "stopped") calls.push(["tatu.set", id, "joint.position", to]);
  if (isDriven) calls.push(["tatu.set", id, "joint.target_position", to]);
  return calls;
}
