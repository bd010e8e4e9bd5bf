// The connection of a film: what was recorded is told as if it came just now.

const handlers = new Map();

/** Calls `f` with each message of a kind: a key of its JSON, or "frame", "mesh", "image". */
export function on(kind, f) {
  if (!handlers.has(kind)) handlers.set(kind, []);
  handlers.get(kind).push(f);
}

/** Tells a message of a kind. */
export function tell(kind, value) {
  for (const f of handlers.get(kind) ?? []) f(value);
}

/** Tells a message of JSON under each of its keys. */
export function say(message) {
  for (const kind of Object.keys(message)) tell(kind, message);
}

/** A film takes nothing. */
export function send() {}

export async function call() {
  throw { error: "a film cannot be changed" };
}
