// @ts-check
// Pending calls, by number. This module does not need a page.

/** @import { ToPage } from "tatu/protocol" */

/**
 * The error of a failed call.
 * @typedef {{ error: string, help?: string }} Failure
 */

/**
 * Converts a thrown value to a failure.
 * @param {unknown} thrown
 * @returns {Failure}
 */
export function failure(thrown) {
  if (typeof thrown === "object" && thrown !== null && "error" in thrown) return /** @type {Failure} */ (thrown);
  return { error: String(thrown instanceof Error ? thrown.message : thrown) };
}

/**
 * Returns the text of an error for display, without the names of the commands that were called.
 * @param {unknown} thrown
 */
export function reason(thrown) {
  const { error, help } = failure(thrown);
  const said = error.replace(/^((tatu|sim)\.\w+: )+/, "");
  return help ? `${said}; ${help}` : said;
}

/** Calls that have not been answered yet. */
export class Calls {
  #last = 0;
  /** @type {Map<number, { what: string, good: (results: any[]) => void, bad: (failure: Failure) => void }>} */
  #waiting = new Map();

  /**
   * Creates a call: returns its number, and a promise of its results. `what` is the name of the call in errors.
   * @param {string} what
   * @returns {{ id: number, results: Promise<any[]> }}
   */
  begin(what) {
    const id = ++this.#last;
    const results = new Promise((/** @type {(results: any[]) => void} */ good, bad) => this.#waiting.set(id, { what, good, bad }));
    return { id, results };
  }

  /**
   * Settles the call that a message answers; returns false if there is no such call.
   * @param {ToPage} message
   */
  answer(message) {
    if (message.type !== "result" && message.type !== "error") return false;
    const waiting = message.of === undefined ? undefined : this.#waiting.get(message.of);
    if (message.of === undefined || !waiting) return false;
    this.#waiting.delete(message.of);
    if (message.type === "error") waiting.bad(message);
    else waiting.good(message.results);
    return true;
  }

  /** Rejects all pending calls, because their answers will not arrive over a new connection. */
  lose() {
    const all = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const { what, bad } of all) {
      bad({ error: `the connection was lost before the program answered ${what}`, help: "check whether it was done, and repeat it if not" });
    }
  }

  /** The number of pending calls. */
  get size() {
    return this.#waiting.size;
  }
}

/**
 * Returns a function that sends values of which only the newest matters: at most one is in flight, and the last one is
 * always sent.
 * @template T
 * @param {(value: T) => Promise<unknown>} deliver
 * @returns {(value: T) => Promise<void>} settled once nothing is left to send
 */
export function newest(deliver) {
  /** @type {{ value: T } | null} */
  let next = null;
  /** @type {Promise<void> | null} */
  let going = null;
  const go = async () => {
    try {
      while (next) {
        const { value } = next;
        next = null;
        try {
          await deliver(value);
        } catch (e) {
          // The error is ignored if there is a newer value, which may succeed.
          if (!next) throw e;
        }
      }
    } finally {
      going = null;
    }
  };
  return (value) => {
    next = { value };
    going ??= go();
    return going;
  };
}
