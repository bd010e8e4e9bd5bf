// @ts-check
// Tracks pending calls by their numbers. This module does not access the DOM, so it can be tested without a browser.

import { t } from "tatu/lib/language";
/** @import { ToPage } from "tatu/protocol" */

/**
 * The error of a failed call, and advice on how to fix it; `lost`: it failed because there was no connection.
 * @typedef {{ error: string, help?: string, lost?: boolean }} Failure
 */

/**
 * Converts any thrown value to a failure.
 * @param {unknown} thrown
 * @returns {Failure}
 */
export function failure(thrown) {
  if (typeof thrown === "object" && thrown !== null && "error" in thrown) return /** @type {Failure} */ (thrown);
  return { error: String(thrown instanceof Error ? thrown.message : thrown) };
}

/**
 * Returns an error message without the names of the commands that the page has called, which precede the message.
 * @param {string} error
 */
export function withoutCommands(error) {
  return error.replace(/^((tatu|sim)\.\w+: )+/, "");
}

/**
 * Returns the message and help of an error for display, without the names of the commands that were called.
 * @param {unknown} thrown
 */
export function reason(thrown) {
  const { error, help } = failure(thrown);
  const text = withoutCommands(error);
  return help ? `${text}; ${help}` : text;
}

/** The calls that have not been answered yet. */
export class Calls {
  #last = 0;
  /** @type {Map<number, { what: string, resolve: (results: any[]) => void, reject: (failure: Failure) => void }>} */
  #waiting = new Map();

  /**
   * Registers a call. Returns its number and a promise of its results; `what` describes the call in error messages.
   * @param {string} what
   * @returns {{ id: number, results: Promise<any[]> }}
   */
  begin(what) {
    const id = ++this.#last;
    const results = new Promise((/** @type {(results: any[]) => void} */ resolve, reject) => this.#waiting.set(id, { what, resolve, reject }));
    return { id, results };
  }

  /**
   * Settles the pending call that a message answers. Returns false if the message does not answer a pending call.
   * @param {ToPage} message
   */
  answer(message) {
    if (message.type !== "result" && message.type !== "error") return false;
    const waiting = message.of === undefined ? undefined : this.#waiting.get(message.of);
    if (message.of === undefined || !waiting) return false;
    this.#waiting.delete(message.of);
    if (message.type === "error") waiting.reject(message);
    else waiting.resolve(message.results);
    return true;
  }

  /** Rejects all pending calls, because their answers will not arrive over a new connection. */
  rejectAll() {
    const all = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const { what, reject } of all) {
      reject({ error: t`the connection was lost before the program answered ${what}`, help: t`check whether it was done, and repeat it if not`, lost: true });
    }
  }

  /** Returns the number of pending calls. */
  get size() {
    return this.#waiting.size;
  }
}

/**
 * Returns a function that sends values of which only the newest matters. While a value is being delivered, newer values
 * replace each other; the last one is always sent.
 * @template T
 * @param {(value: T) => Promise<unknown>} deliver
 * @returns {(value: T) => Promise<void>} the promise is settled when no value is left to be sent
 */
export function sendLatest(deliver) {
  /** @type {{ value: T } | null} */
  let next = null;
  /** @type {Promise<void> | null} */
  let running = null;
  const run = async () => {
    try {
      while (next) {
        const { value } = next;
        next = null;
        try {
          await deliver(value);
        } catch (e) {
          // The error does not matter if a newer value follows, which may succeed.
          if (!next) throw e;
        }
      }
    } finally {
      running = null;
    }
  };
  return (value) => {
    next = { value };
    running ??= run();
    return running;
  };
}
