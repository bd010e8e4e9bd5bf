// The connection: what comes in is handed to whoever asked for its kind.

const handlers = new Map();
let socket = null;
/** The program, as it says at `/tatu`; a program that was started again has another instance. */
let program = "";
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

function isOpen() {
  return socket?.readyState === WebSocket.OPEN;
}

/** Sends a message; without a connection it is lost. */
export function send(message) {
  if (isOpen()) socket.send(JSON.stringify(message));
}

/** Sends a message that is answered; a promise of its results. */
export function ask(message, what) {
  const id = ++asked;
  return new Promise((good, bad) => {
    if (!isOpen()) {
      bad({ error: `${what} was not done: there is no connection to the program`, help: "do it again once the page is connected" });
      return;
    }
    waiting.set(id, { good, bad, what });
    send({ ...message, id });
  });
}

/** Calls a command; a promise of its results. */
export function call(name, ...args) {
  return ask({ call: name, args }, `\`${name}\``);
}

/** Refuses what is not answered yet: its answer will not come over another connection. */
function refuseAll() {
  const all = [...waiting.values()];
  waiting.clear();
  for (const { bad, what } of all) {
    bad({ error: `the connection was lost before the program answered ${what}`, help: "look whether it was done, and do it again if not" });
  }
}

/** Bytes of a part of a file. */
const PART = 2 << 20;

/** Sends a file in parts; a promise of its name for commands. */
export async function upload(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const what = `the file ${file.name}`;
  if (!isOpen()) throw { error: `${what} was not sent: there is no connection to the program`, help: "drop it again once the page is connected" };
  const id = ++asked;
  const done = new Promise((good, bad) => waiting.set(id, { good: ([name]) => good(name), bad, what }));
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

/** Waits between attempts to connect, ms. */
const WAITS = [100, 200, 400, 800, 1500, 2000];
/** How long an answer may take before nobody is there, ms. */
const PATIENCE = 2000;

function get(path) {
  return fetch(path, { cache: "no-store", signal: AbortSignal.timeout(PATIENCE) });
}

/** Who is at this address: what the program says of itself; null for another program, undefined for nobody. */
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

/** Whether the program refuses the token; without an upgrade, the path of the connection says no more than this. */
async function isRefused() {
  try {
    return (await get(`/ws?token=${token()}`)).status === 401;
  } catch {
    return false;
  }
}

/** Opens a socket; a promise of whether it has opened. */
function open(instance) {
  return new Promise((done) => {
    const own = new WebSocket(`ws://${location.host}/ws?token=${token()}`);
    own.binaryType = "arraybuffer";
    own.onmessage = receive;
    own.onopen = () => {
      socket = own;
      // The program tells everything from the beginning: what the last connection has told is forgotten before.
      if (program) tell("again", { restarted: program !== instance });
      program = instance;
      done(true);
    };
    own.onclose = () => {
      if (socket === own) {
        socket = null;
        refuseAll();
        connect();
      }
      done(false);
    };
  });
}

/** One attempt: whether it has succeeded. What prevents it is told as "lost": gone, other, or old. */
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

/** Connects, and again whenever the connection is lost. */
export async function connect() {
  for (let n = 0; !(await attempt()); n++) {
    await new Promise((later) => setTimeout(later, WAITS[Math.min(n, WAITS.length - 1)]));
  }
}
