// @ts-check
// Replaces the module `net/connection` in a film: delivers recorded messages as if they had just been received.

import { expandCopies } from "tatu/net/model_copies";

/** @import { FromPage, ToPage } from "tatu/protocol" */
/** @import { Messages } from "tatu/net/connection" */

/** @type {Map<string, ((message: any) => void)[]>} */
const handlers = new Map();

/**
 * Calls `f` with each message of a kind. For text messages, the kind is their `type`; for binary ones, it is "frame",
 * "mesh" or "texture".
 * @template {keyof Messages} K
 * @param {K} kind
 * @param {(message: Messages[K]) => void} f
 */
export function on(kind, f) {
  const all = handlers.get(kind);
  if (all) all.push(f);
  else handlers.set(kind, [f]);
}

/**
 * Delivers a message of a kind.
 * @template {keyof Messages} K
 * @param {K} kind
 * @param {Messages[K]} message
 */
export function deliver(kind, message) {
  for (const f of handlers.get(kind) ?? []) f(message);
}

/**
 * Delivers a JSON message.
 * @param {ToPage} message
 */
export function deliverMessage(message) {
  if (message.type === "scene") deliver("scene", { ...message, objects: expandCopies(message.objects) });
  else deliver(/** @type {any} */ (message.type), /** @type {any} */ (message));
}

/**
 * Does nothing, because a film is not connected to a program.
 * @param {FromPage} _message
 */
export function send(_message) {
  return false;
}

/**
 * Throws a failure, because a film is not connected to a program.
 * @param {string} _name
 * @param {...unknown} _args
 * @returns {Promise<any[]>}
 */
export async function call(_name, ..._args) {
  throw { error: "a film cannot be changed" };
}
