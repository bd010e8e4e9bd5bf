import assert from "node:assert/strict";
import { test } from "node:test";

import { Calls, failure, sendLatest, reason } from "../net/calls.js";

test("answers settle the calls that they name, in any order", async () => {
  const calls = new Calls();
  const [a, b] = [calls.begin("it"), calls.begin("it")];
  assert.notEqual(a.id, b.id);
  assert.ok(calls.answer({ type: "result", of: b.id, results: ["b"] }));
  assert.ok(calls.answer({ type: "result", of: a.id, results: ["a", 1] }));
  assert.deepEqual([await a.results, await b.results], [["a", 1], ["b"]]);
  assert.equal(calls.size, 0);
});

test("errors refuse the call that they name", async () => {
  const calls = new Calls();
  const { id, results } = calls.begin("it");
  assert.ok(calls.answer({ type: "error", of: id, error: "no such object", help: "look again" }));
  await assert.rejects(results, { error: "no such object", help: "look again" });
});

test("what answers no call is left to others", async () => {
  const calls = new Calls();
  const { id, results } = calls.begin("it");
  assert.ok(!calls.answer({ type: "error", error: "a request lacks the key `type`" }));
  assert.ok(!calls.answer({ type: "result", of: id + 1, results: [] }));
  assert.ok(!calls.answer({ type: "script", script: id, text: "" }));
  assert.equal(calls.size, 1);
  calls.answer({ type: "result", of: id, results: [] });
  assert.ok(!calls.answer({ type: "result", of: id, results: [2] }), "a call is answered once");
  assert.deepEqual(await results, []);
});

test("all calls are refused when the connection closes, with what was asked", async () => {
  const calls = new Calls();
  const all = ["`tatu.list`", "opening a.toml"].map((what) => calls.begin(what).results);
  calls.rejectAll();
  const reasons = (await Promise.allSettled(all)).map((result) => result.status === "rejected" && result.reason);
  assert.ok(reasons.every((reason) => reason.lost), "what was lost may be repeated");
  const errors = reasons.map((reason) => reason.error);
  assert.deepEqual(errors, [
    "the connection was lost before the program answered `tatu.list`",
    "the connection was lost before the program answered opening a.toml",
  ]);
  assert.equal(calls.size, 0);
  const { id, results } = calls.begin("it");
  calls.answer({ type: "result", of: id, results: [1] });
  assert.deepEqual(await results, [1], "a later connection is another matter");
});

test("failures are texts, whatever was thrown", () => {
  assert.deepEqual(failure({ error: "a", help: "b" }), { error: "a", help: "b" });
  assert.deepEqual(failure(new TypeError("t")), { error: "t" });
  assert.deepEqual(failure("text"), { error: "text" });
});

test("reasons are for people", () => {
  assert.equal(reason({ error: "tatu.edit: tatu.set: mass must be greater than 0" }), "mass must be greater than 0");
  assert.equal(reason({ error: "no such object", help: "look again" }), "no such object; look again");
});

/** Returns a delivery function and the values that it received. `end` and `fail` settle its oldest pending promise. */
function slow() {
  const sent = [];
  const ends = [];
  const deliver = (value) => new Promise((good, bad) => { sent.push(value); ends.push({ good, bad }); });
  const turn = () => new Promise((done) => setImmediate(done));
  return { sent, deliver, end: async () => { ends.shift().good(); await turn(); }, fail: async () => { ends.shift().bad(new Error("no")); await turn(); } };
}

test("at most one value is on the way, and the last one always arrives", async () => {
  const { sent, deliver, end } = slow();
  const put = sendLatest(deliver);
  const done = put(1);
  put(2);
  put(3);
  assert.deepEqual(sent, [1]);
  await end();
  assert.deepEqual(sent, [1, 3]);
  put(4);
  await end();
  assert.deepEqual(sent, [1, 3, 4]);
  await end();
  await done;
  put(5);
  assert.deepEqual(sent, [1, 3, 4, 5]);
});

test("the last value is sent though one before it failed", async () => {
  const { sent, deliver, end, fail } = slow();
  const put = sendLatest(deliver);
  const done = put(1);
  put(2);
  await fail();
  assert.deepEqual(sent, [1, 2]);
  await end();
  await done;
  const failed = put(3);
  failed.catch(() => {});
  await fail();
  await assert.rejects(failed, /no/);
});
