// @ts-check
// Calls that wait for their results, by number. Nothing here needs a page.

/** @import { ToPage } from "tatu/protocol" */

/**
 * Why a call failed.
 * @typedef {{ error: string, help?: string }} Failure
 */

/**
 * Failures as this page has them, whatever was thrown.
 * @param {unknown} thrown
 * @returns {Failure}
 */
export function failure(thrown) {
  if (typeof thrown === "object" && thrown !== null && "error" in thrown) return /** @type {Failure} */ (thrown);
  return { error: String(thrown instanceof Error ? thrown.message : thrown) };
}

/**
 * Why something was refused, for people: without the names of the commands that were called for it.
 * @param {unknown} thrown
 */
export function reason(thrown) {
  const { error, help } = failure(thrown);
  const said = error.replace(/^((tatu|sim)\.\w+: )+/, "");
  return help ? `${said}; ${help}` : said;
}

/** Calls that wait for their results. */
export class Calls {
  #last = 0;
  /** @type {Map<number, { what: string, good: (results: any[]) => void, bad: (failure: Failure) => void }>} */
  #waiting = new Map();

  /**
   * A new number, and a promise of the results of the call that has it. `what` names in errors what was asked.
   * @param {string} what
   * @returns {{ id: number, results: Promise<any[]> }}
   */
  begin(what) {
    const id = ++this.#last;
    const results = new Promise((/** @type {(results: any[]) => void} */ good, bad) => this.#waiting.set(id, { what, good, bad }));
    return { id, results };
  }

  /**
   * Settles the call that a message answers; false: it answers none.
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

  /** Refuses all calls that wait: their answers will not come over another connection. */
  lose() {
    const all = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const { what, bad } of all) {
      bad({ error: `the connection was lost before the program answered ${what}`, help: "look whether it was done, and do it again if not" });
    }
  }

  /** How many calls wait. */
  get size() {
    return this.#waiting.size;
  }
}

/**
 * Sends values of which only the newest matters: at most one is on the way, and the last one always arrives.
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
          // What is newer may well succeed.
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
