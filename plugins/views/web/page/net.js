// @ts-check
// The connection to the program: passes incoming messages to the handlers of their kind.

import { Calls } from "tatu/calls";
import { BINARY } from "tatu/parse";

/** @import { FromPage, ToPage } from "tatu/protocol" */

/** @typedef {{ name: string, service: string, instance: string }} Program What a program says of itself at `/tatu`. */
/**
 * The arguments of handlers, by the kind of message: text messages of the program, binary messages, and messages of the
 * connection itself: "lost" with the reason, "connected", and "again" before the first message of a later connection.
 * @typedef {{ [M in ToPage as M["type"]]: M } & { frame: DataView, mesh: DataView, image: DataView, texture: DataView,
 *   lost: "gone" | "other" | "old", connected: null, again: { restarted: boolean } }} Messages
 */
/**
 * A request that gets an answer, without its number.
 * @typedef {FromPage extends infer M ? M extends { id: number } ? Omit<M, "id"> : never : never} Asked
 */

/** @type {Map<string, ((message: any) => void)[]>} */
const handlers = new Map();
/** @type {WebSocket | null} */
let socket = null;
/** The instance of the program that the page was connected to; a restarted program has a different one. */
let program = "";
const calls = new Calls();

/**
 * Calls `f` with each message of a kind: the `type` of its JSON, or "frame", "mesh", "image", "texture", "lost",
 * "connected", "again".
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
 * @template {keyof Messages} K
 * @param {K} kind
 * @param {Messages[K]} message
 */
function tell(kind, message) {
  for (const f of handlers.get(kind) ?? []) f(message);
}

/**
 * Sends a message; returns false if there is no connection.
 * @param {FromPage} message
 */
export function send(message) {
  if (socket?.readyState !== WebSocket.OPEN) return false;
  socket.send(JSON.stringify(message));
  return true;
}

/**
 * Sends a message that gets an answer; returns a promise of its results, or of a failure. `what` is its name in errors.
 * @param {Asked} message
 * @param {string} what
 * @returns {Promise<any[]>}
 */
export async function ask(message, what) {
  needConnection(`${what} was not done`, "do it again once the page is connected");
  const { id, results } = calls.begin(what);
  send(/** @type {FromPage} */ ({ ...message, id }));
  return results;
}

/**
 * Throws a failure if there is no connection.
 * @param {string} result
 * @param {string} help
 */
function needConnection(result, help) {
  if (socket?.readyState !== WebSocket.OPEN) throw { error: `${result}: there is no connection to the program`, help };
}

/**
 * Calls a command; returns a promise of its results, or of a failure `{ error, help }`.
 * @param {string} name
 * @param {...unknown} args
 */
export function call(name, ...args) {
  return ask({ type: "call", name, args }, `\`${name}\``);
}

/** Size of the parts of a file, bytes. */
const PART = 2 << 20;

/**
 * Sends a file in parts; returns a promise of its name for commands.
 * @param {File} file
 * @param {string} [name] with its folders, below `folder`
 * @param {string} [folder] the answer to the message `folder`
 * @returns {Promise<string>}
 */
export async function upload(file, name = file.name, folder) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const what = `the file ${name}`;
  needConnection(`${what} was not sent`, "drop it again once the page is connected");
  const { id, results } = calls.begin(what);
  for (let at = 0; at === 0 || at < bytes.length; at += PART) {
    let text = "";
    for (const b of bytes.subarray(at, at + PART)) text += String.fromCharCode(b);
    send({ type: "drop", id, file: name, part: btoa(text), last: at + PART >= bytes.length, ...(folder && { folder }) });
  }
  return (await results)[0];
}

/** @param {MessageEvent} event */
function receive(event) {
  if (event.data instanceof ArrayBuffer) {
    const view = new DataView(event.data);
    const kind = BINARY[view.getUint8(0)];
    if (kind) tell(kind, view);
    return;
  }
  /** @type {ToPage} */
  const message = JSON.parse(event.data);
  if (!calls.answer(message)) tell(message.type, /** @type {any} */ (message));
}

/** The token: from the address, from which it is then removed, or stored before a reload of the page. */
function token() {
  const found = new URLSearchParams(location.search).get("token");
  if (found) {
    sessionStorage.setItem("token", found);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token") ?? "";
}

/** Delays between attempts to connect, ms. */
const WAITS = [100, 200, 400, 800, 1500, 2000];
/** Time without an answer after which the program counts as unreachable, ms. */
const PATIENCE = 2000;

/** @param {string} path */
function get(path) {
  return fetch(path, { cache: "no-store", signal: AbortSignal.timeout(PATIENCE) });
}

/**
 * Queries the program at this address; returns a promise of its description, of null for another program, or of
 * undefined if nothing answers.
 * @returns {Promise<Program | null | undefined>}
 */
async function whoIsThere() {
  let answer;
  try {
    answer = await get("/tatu");
  } catch {
    return undefined;
  }
  try {
    const told = await answer.json();
    return told?.name === "tatu" && told.service === "web" ? told : null;
  } catch {
    return null;
  }
}

/** Returns whether the program refuses the token, which it also reports to requests without a WebSocket upgrade. */
async function isRefused() {
  try {
    return (await get(`/ws?token=${token()}`)).status === 401;
  } catch {
    return false;
  }
}

/**
 * Opens a WebSocket to a program; returns a promise of whether that succeeded.
 * @param {string} instance
 * @returns {Promise<boolean>}
 */
function open(instance) {
  return new Promise((done) => {
    const own = new WebSocket(`ws://${location.host}/ws?token=${token()}`);
    own.binaryType = "arraybuffer";
    own.onmessage = receive;
    own.onopen = () => {
      socket = own;
      // The program sends its whole state again, so the state from the last connection is reset first.
      if (program) tell("again", { restarted: program !== instance });
      program = instance;
      done(true);
    };
    own.onclose = () => {
      if (socket === own) {
        socket = null;
        calls.lose();
        connect();
      }
      done(false);
    };
  });
}

/** Makes one attempt; returns whether it succeeded. The cause of a failure is sent as "lost": gone, other or old. */
async function attempt() {
  const told = await whoIsThere();
  if (!told) {
    tell("lost", told === null ? "other" : "gone");
    return false;
  }
  if (await open(told.instance)) {
    tell("connected", null);
    return true;
  }
  tell("lost", (await isRefused()) ? "old" : "gone");
  return false;
}

/** Connects, and reconnects whenever the connection is lost. */
export async function connect() {
  for (let n = 0; !(await attempt()); n++) {
    const wait = WAITS[Math.min(n, WAITS.length - 1)];
    await new Promise((later) => setTimeout(later, wait));
  }
}
