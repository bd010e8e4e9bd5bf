// The connection: what comes in is handed to whoever asked for its kind.

const handlers = new Map();
let socket = null;
let asked = 0;
const waiting = new Map();

/** Calls `f` with each message of a kind: a key of its JSON, or "frame", "mesh", "image". */
export function on(kind, f) {
  if (!handlers.has(kind)) handlers.set(kind, []);
  handlers.get(kind).push(f);
}

function tell(kind, value) {
  for (const f of handlers.get(kind) ?? []) f(value);
}

/** Sends a message. */
export function send(message) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

/** Calls a command; a promise of its results. */
export function call(name, ...args) {
  const id = ++asked;
  send({ call: name, args, id });
  return new Promise((good, bad) => waiting.set(id, { good, bad }));
}

/** Bytes of a part of a file. */
const PART = 2 << 20;

/** Sends a file in parts; a promise of its name for commands. */
export async function upload(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const id = ++asked;
  const done = new Promise((good, bad) => waiting.set(id, { good: ([name]) => good(name), bad }));
  for (let at = 0; at === 0 || at < bytes.length; at += PART) {
    let text = "";
    for (const b of bytes.subarray(at, at + PART)) text += String.fromCharCode(b);
    send({ drop: file.name, part: btoa(text), last: at + PART >= bytes.length, id });
  }
  return done;
}

const BINARY = { 1: "frame", 2: "mesh", 3: "image" };

function receive(event) {
  if (event.data instanceof ArrayBuffer) {
    const view = new DataView(event.data);
    return tell(BINARY[view.getUint8(0)], view);
  }
  const message = JSON.parse(event.data);
  const promise = waiting.get(message.of);
  if (promise) {
    waiting.delete(message.of);
    if ("error" in message) promise.bad(message);
    else promise.good(message.result);
    return;
  }
  for (const kind of Object.keys(message)) tell(kind, message);
}

/** The token: from the address, which then forgets it, or from before a reload. */
function token() {
  const found = new URLSearchParams(location.search).get("token");
  if (found) {
    sessionStorage.setItem("token", found);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token") ?? "";
}

/** Connects; once. */
export function connect() {
  socket = new WebSocket(`ws://${location.host}/ws?token=${token()}`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = receive;
  socket.onclose = () => tell("closed", null);
}
