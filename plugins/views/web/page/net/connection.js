// @ts-check
// The connection to the program. Sends requests, and passes received messages to the handlers of their kind.

import { t } from "tatu/lib/language";
import { BINARY } from "tatu/net/binary_messages";
import { Calls, failure } from "tatu/net/calls";
import { expandCopies } from "tatu/net/model_copies";

/** @import { FromPage, SceneObject, ToPage } from "tatu/protocol" */

/** @typedef {{ name: string, service: string, instance: string }} Program The description of a program at `/tatu`. */
/**
 * The arguments of handlers, by the kind of message: text messages by their `type`, binary messages, and messages about
 * the connection: "lost" with the reason, "connected", and "again" before the first message after a reconnection.
 * A scene has the objects of all its models, and output arrives as single events.
 * @typedef {{ [M in Exclude<ToPage, { type: "scene" | "output" }> as M["type"]]: M } & { scene: Omit<ToPage & { type: "scene" }, "objects"> & { objects: SceneObject[] }, frame: DataView, mesh: DataView, image: DataView, texture: DataView,
 *   lost: "gone" | "other" | "old", connected: null, again: { restarted: boolean } }} Messages
 */
/**
 * A request with an answer, without its number.
 * @typedef {FromPage extends infer M ? M extends { id: number } ? Omit<M, "id"> : never : never} Request
 */

/** @type {Map<string, ((message: any) => void)[]>} */
const handlers = new Map();
/** @type {WebSocket | null} */
let socket = null;
/** The id of the program instance that the page was connected to last. A restarted program has a different id. */
let program = "";
const calls = new Calls();
/** Called at the next connection. @type {((value: unknown) => void)[]} */
const connectionWaiters = [];

/**
 * Calls `f` with each message of a kind. The kind of a text message is its `type`; other kinds are "frame", "mesh",
 * "image", "texture", "lost", "connected" and "again".
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
 * Passes a message to the handlers of its kind.
 * @template {keyof Messages} K
 * @param {K} kind
 * @param {Messages[K]} message
 */
function dispatch(kind, message) {
  for (const f of handlers.get(kind) ?? []) f(message);
}

/**
 * Sends a request. Returns false if the page is not connected.
 * @param {FromPage} message
 */
export function send(message) {
  if (socket?.readyState !== WebSocket.OPEN) return false;
  socket.send(JSON.stringify(message));
  return true;
}

/**
 * Sends a request with an answer. Returns a promise of the results, which is rejected with a failure;
 * `description` describes the request in error messages.
 * @param {Request} message
 * @param {string} description
 * @returns {Promise<any[]>}
 */
export async function ask(message, description) {
  requireConnection(`${description} was not done`, "do it again once the page is connected");
  const { id, results } = calls.begin(description);
  send(/** @type {FromPage} */ ({ ...message, id }));
  return results;
}

/**
 * Throws a failure if the page is not connected.
 * @param {string} result the consequence, for the error message
 * @param {string} help
 */
function requireConnection(result, help) {
  if (socket?.readyState !== WebSocket.OPEN) throw { error: t`${result}: there is no connection to the program`, help, lost: true };
}

/**
 * Calls a command. Returns a promise of its results, which is rejected with a failure `{ error, help }`.
 * @param {string} name
 * @param {...unknown} args
 */
export function call(name, ...args) {
  return ask({ type: "call", name, args }, `\`${name}\``);
}

/** Number of times that something is done before a lost connection is reported. */
const ATTEMPTS = 3;
/** Time to wait for a connection, ms. */
const MAX_CONNECTION_WAIT = 20000;

/** Returns a promise that is settled when the page is connected, or when it has waited for too long. */
function connection() {
  return new Promise((/** @type {(value: unknown) => void} */ resolve) => {
    if (socket?.readyState === WebSocket.OPEN) return resolve(null);
    connectionWaiters.push(resolve);
    setTimeout(resolve, MAX_CONNECTION_WAIT);
  });
}

/**
 * Does something that needs the connection, and repeats it if the connection is lost meanwhile: while a page that has
 * just been opened loads on a busy computer, the program may close a connection from which nothing is read.
 * @template T
 * @param {() => Promise<T>} operation
 * @returns {Promise<T>}
 */
export async function withRetries(operation) {
  for (let n = 1; ; n++) {
    await connection();
    try {
      return await operation();
    } catch (thrown) {
      if (n === ATTEMPTS || !failure(thrown).lost) throw thrown;
    }
  }
}

/** Size of the parts in which a file is sent, bytes. */
const PART_BYTES = 2 << 20;

/**
 * Sends a file in parts. Returns a promise of the path by which commands open the file.
 * @param {File} file
 * @param {string} [name] path of the file within `folder`
 * @param {string} [folder] the answer to a `folder` request
 * @returns {Promise<string>}
 */
export async function upload(file, name = file.name, folder) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const description = `the file ${name}`;
  requireConnection(`${description} was not sent`, "drop it again once the page is connected");
  const { id, results } = calls.begin(description);
  for (let offset = 0; offset === 0 || offset < bytes.length; offset += PART_BYTES) {
    let text = "";
    for (const b of bytes.subarray(offset, offset + PART_BYTES)) text += String.fromCharCode(b);
    send({ type: "drop", id, file: name, part: btoa(text), last: offset + PART_BYTES >= bytes.length, ...(folder && { folder }) });
  }
  return (await results)[0];
}

/** Handles a received message. @param {MessageEvent} event */
function receive(event) {
  if (event.data instanceof ArrayBuffer) {
    const view = new DataView(event.data);
    const kind = BINARY[view.getUint8(0)];
    if (kind) dispatch(kind, view);
    return;
  }
  /** @type {ToPage} */
  const message = JSON.parse(event.data);
  if (calls.answer(message)) return;
  if (message.type === "scene") dispatch("scene", { ...message, objects: expandCopies(message.objects) });
  else if (message.type === "output") for (const line of message.lines) dispatch("event", { type: "event", ...line });
  else dispatch(message.type, /** @type {any} */ (message));
}

/** Returns the token. It is moved from the address to the session storage, from which it is read after a reload. */
function token() {
  const given = new URLSearchParams(location.search).get("token");
  if (given) {
    sessionStorage.setItem("token", given);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token") ?? "";
}

/** Delays after unsuccessful attempts to connect, ms; the last one is repeated. */
const RETRY_DELAYS = [100, 200, 400, 800, 1500, 2000];
/** Time after which a request to the program is considered unanswered, ms. */
const REQUEST_TIMEOUT = 2000;

/** Requests a path from the program at this address. @param {string} path */
function request(path) {
  return fetch(path, { cache: "no-store", signal: AbortSignal.timeout(REQUEST_TIMEOUT) });
}

/**
 * Queries the program at this address. Returns a promise of its description, of null if another program answers, or of
 * undefined if no program answers.
 * @returns {Promise<Program | null | undefined>}
 */
async function describeProgram() {
  let answer;
  try {
    answer = await request("/tatu");
  } catch {
    return undefined;
  }
  try {
    const description = await answer.json();
    return description?.name === "tatu" && description.service === "web" ? description : null;
  } catch {
    return null;
  }
}

/**
 * Returns a promise of whether the program rejects the token. An ordinary request suffices, because the program checks
 * the token before it expects a WebSocket handshake.
 */
async function isTokenRefused() {
  try {
    return (await request(`/ws?token=${token()}`)).status === 401;
  } catch {
    return false;
  }
}

/**
 * Opens a WebSocket to the program. Returns a promise of whether that succeeded.
 * @param {string} instance id of the program instance
 * @returns {Promise<boolean>}
 */
function open(instance) {
  return new Promise((resolve) => {
    const candidate = new WebSocket(`ws://${location.host}/ws?token=${token()}`);
    candidate.binaryType = "arraybuffer";
    candidate.onmessage = receive;
    candidate.onopen = () => {
      socket = candidate;
      // The program sends its complete state again, so handlers must first discard the state of the last connection.
      if (program) dispatch("again", { restarted: program !== instance });
      program = instance;
      for (const f of connectionWaiters.splice(0)) f(null);
      resolve(true);
    };
    candidate.onclose = () => {
      if (socket === candidate) {
        socket = null;
        calls.rejectAll();
        connect();
      }
      resolve(false);
    };
  });
}

/** Tries to connect once. Returns a promise of whether that succeeded; if not, handlers of "lost" get the reason. */
async function attempt() {
  const description = await describeProgram();
  if (!description) {
    dispatch("lost", description === null ? "other" : "gone");
    return false;
  }
  if (await open(description.instance)) {
    dispatch("connected", null);
    return true;
  }
  dispatch("lost", (await isTokenRefused()) ? "old" : "gone");
  return false;
}

/** Connects to the program; retries until that succeeds. Called again when the connection is lost. */
export async function connect() {
  for (let n = 0; !(await attempt()); n++) {
    const wait = RETRY_DELAYS[Math.min(n, RETRY_DELAYS.length - 1)];
    await new Promise((resolve) => setTimeout(resolve, wait));
  }
}
