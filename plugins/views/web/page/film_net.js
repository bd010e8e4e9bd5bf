// @ts-check
// Replaces the connection in a film: recorded messages are delivered as if they had just arrived.

/** @import { FromPage, ToPage } from "tatu/protocol" */
/** @import { Messages } from "tatu/net" */

/** @type {Map<string, ((message: any) => void)[]>} */
const handlers = new Map();

/**
 * Calls `f` with each message of a kind: the `type` of its JSON, or "frame" or "mesh".
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
export function tell(kind, message) {
  for (const f of handlers.get(kind) ?? []) f(message);
}

/**
 * Delivers a JSON message.
 * @param {ToPage} message
 */
export function say(message) {
  tell(message.type, /** @type {any} */ (message));
}

/**
 * Does nothing: there is no program to send messages to.
 * @param {FromPage} _message
 */
export function send(_message) {
  return false;
}

/**
 * @param {string} _name
 * @param {...unknown} _args
 * @returns {Promise<any[]>}
 */
export async function call(_name, ..._args) {
  throw { error: "a film cannot be changed" };
}
