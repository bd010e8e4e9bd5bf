import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { deflateRawSync } from "node:zlib";

import { pack, unzip } from "../lib/zip.js";

/** Builds a zip archive of files, which are deflated unless `packed` is false. */
function archive(files) {
  const local = [];
  const central = [];
  let at = 0;
  for (const { name, text, packed = true, size } of files) {
    const raw = Buffer.from(text);
    const data = packed ? deflateRawSync(raw) : raw;
    const head = Buffer.alloc(30);
    head.writeUInt32LE(0x04034b50, 0);
    head.writeUInt16LE(name.length, 26);
    const entry = Buffer.alloc(46);
    entry.writeUInt32LE(0x02014b50, 0);
    entry.writeUInt16LE(packed ? 8 : 0, 10);
    entry.writeUInt32LE(data.length, 20);
    entry.writeUInt32LE(size ?? raw.length, 24);
    entry.writeUInt16LE(name.length, 28);
    entry.writeUInt32LE(at, 42);
    local.push(head, Buffer.from(name), data);
    central.push(entry, Buffer.from(name));
    at += 30 + name.length + data.length;
  }
  const end = Buffer.alloc(22);
  end.writeUInt32LE(0x06054b50, 0);
  end.writeUInt16LE(files.length, 10);
  end.writeUInt32LE(at, 16);
  const all = Buffer.concat([...local, ...central, end]);
  return all.buffer.slice(all.byteOffset, all.byteOffset + all.length);
}

const texts = (files) => files.map(({ name, bytes }) => [name, new TextDecoder().decode(bytes)]);

test("files are unpacked with their folders, folders themselves are left out", async () => {
  const buffer = archive([
    { name: "room/", text: "", packed: false },
    { name: "room/room.toml", text: "format = 1\n".repeat(100) },
    { name: "room/scripts/a.lua", text: "print(1)", packed: false },
  ]);
  assert.deepEqual(texts(await unzip(buffer)), [["room/room.toml", "format = 1\n".repeat(100)], ["room/scripts/a.lua", "print(1)"]]);
  assert.deepEqual(texts(await unzip(buffer, (name) => name.endsWith(".lua"))), [["room/scripts/a.lua", "print(1)"]]);
});

test("files that are larger than they say are refused", async () => {
  await assert.rejects(unzip(archive([{ name: "a.toml", text: "x".repeat(100000), size: 10 }])), (e) => /larger than the size/.test(e.error));
  await assert.rejects(unzip(archive([{ name: "a.toml", text: "x", size: 0xffffffff }])), (e) => /too large/.test(e.error));
});

test("damaged archives are refused", async () => {
  const good = archive([{ name: "a.toml", text: "format = 1" }]);
  for (const bad of [new ArrayBuffer(0), new ArrayBuffer(100), good.slice(0, good.byteLength - 1), good.slice(20)]) {
    await assert.rejects(unzip(bad), (thrown) => /damaged/.test(thrown.error ?? ""));
  }
});

test("what was packed is unpacked, here and by another program", async () => {
  const files = [{ name: "a.txt", bytes: new TextEncoder().encode("caf\u00e9") }, { name: "f/\u00e9.bin", bytes: new Uint8Array([0, 255, 7]) }];
  const packed = pack(files);
  assert.deepEqual(await unzip(packed.buffer), files);
  const folder = mkdtempSync(join(tmpdir(), "tatu-zip-"));
  writeFileSync(join(folder, "a.zip"), packed);
  // Python verifies the checksums.
  const out = execFileSync("python3", ["-c", "import sys, zipfile; z = zipfile.ZipFile(sys.argv[1]); print(z.testzip(), z.namelist())", join(folder, "a.zip")]);
  assert.equal(out.toString().trim(), "None ['a.txt', 'f/\u00e9.bin']");
  rmSync(folder, { recursive: true });
});
