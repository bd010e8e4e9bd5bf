// @ts-check
// Reads zip archives with stored or deflated files, and writes zip archives with stored files. This module does not
// access the DOM, so it can be tested without a browser.

/** Signature of the end record, which contains the number of files and the offset of the directory. */
const END = 0x06054b50;
/** Signature of a directory entry. */
const ENTRY = 0x02014b50;
/** Maximum length of the comment after the end record, bytes. */
const MAX_COMMENT_BYTES = 0xffff;
/** Maximum size of a file, bytes. */
const MAX_FILE_BYTES = 64 << 20;
/** Maximum total size of all files, bytes. */
const MAX_TOTAL_BYTES = 256 << 20;

/** @typedef {{ name: string, bytes: Uint8Array<ArrayBuffer> }} Unpacked */

/**
 * Decompresses deflated data. Throws a failure if the result is larger than `maxBytes` bytes.
 * @param {Uint8Array<ArrayBuffer>} packed
 * @param {number} maxBytes
 */
async function inflate(packed, maxBytes) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  /** @type {Uint8Array[]} */
  const parts = [];
  let length = 0;
  const reader = stream.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    length += value.length;
    // The size stated in the archive cannot be trusted.
    if (length > maxBytes) throw { error: "a file in the zip archive is larger than the size that the archive states" };
    parts.push(value);
  }
  const bytes = new Uint8Array(length);
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

/**
 * Returns a promise of the wanted files in an archive, decompressed.
 * @param {ArrayBuffer} buffer
 * @param {(name: string) => boolean} [accepts]
 * @returns {Promise<Unpacked[]>}
 */
export async function unzip(buffer, accepts = () => true) {
  const view = new DataView(buffer);
  const damaged = { error: "the zip archive is damaged: expected a list of files at its end" };
  let end = buffer.byteLength - 22;
  while (end >= 0 && view.getUint32(end, true) !== END) {
    if (buffer.byteLength - end > MAX_COMMENT_BYTES + 22) throw damaged;
    end--;
  }
  if (end < 0) throw damaged;
  /** @type {Unpacked[]} */
  const files = [];
  let remaining = MAX_TOTAL_BYTES;
  try {
    const count = view.getUint16(end + 10, true);
    let at = view.getUint32(end + 16, true);
    for (let n = 0; n < count; n++) {
      if (view.getUint32(at, true) !== ENTRY) throw damaged;
      const [flags, method] = [view.getUint16(at + 8, true), view.getUint16(at + 10, true)];
      const [packed, size] = [view.getUint32(at + 20, true), view.getUint32(at + 24, true)];
      const [nameLength, extra, comment] = [view.getUint16(at + 28, true), view.getUint16(at + 30, true), view.getUint16(at + 32, true)];
      const name = new TextDecoder().decode(new Uint8Array(buffer, at + 46, nameLength)).replaceAll("\\", "/");
      const local = view.getUint32(at + 42, true);
      at += 46 + nameLength + extra + comment;
      if (name.endsWith("/") || !accepts(name)) continue;
      if (flags & 1) throw { error: `\`${name}\` in the zip archive is encrypted`, help: "create the archive without a password" };
      if (size > Math.min(MAX_FILE_BYTES, remaining)) throw { error: `\`${name}\` in the zip archive is too large: expected at most 64 MiB per file, and 256 MiB for all files` };
      remaining -= size;
      const start = local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true);
      const data = new Uint8Array(buffer, start, packed);
      if (method === 0) files.push({ name, bytes: data.slice() });
      else if (method === 8) files.push({ name, bytes: await inflate(data, size) });
      else throw { error: `\`${name}\` in the zip archive uses the unsupported compression method ${method}`, help: "create the archive with the method deflate, which most programs use by default" };
    }
  } catch (thrown) {
    // An offset outside of the archive causes a `RangeError`, and invalid compressed data causes a `TypeError`.
    throw thrown instanceof RangeError || thrown instanceof TypeError ? damaged : thrown;
  }
  return files;
}

/** @param {Uint8Array} bytes */
function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let i = 0; i < 8; i++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

/** The date of all files, 1980-01-01. It is fixed, so that archives are reproducible. */
const DATE = 0x21;
/** Flag of an entry: the name is in UTF-8. */
const UTF8 = 0x800;

/**
 * Returns an archive that contains the files uncompressed.
 * @param {Unpacked[]} files
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function pack(files) {
  const encoder = new TextEncoder();
  const all = files.map(({ name, bytes }) => ({ name: encoder.encode(name), bytes, crc: crc32(bytes), at: 0 }));
  const total = all.reduce((n, { name, bytes }) => n + 30 + 46 + 2 * name.length + bytes.length, 22);
  const out = new Uint8Array(total);
  const view = new DataView(out.buffer);
  let at = 0;
  const put = (/** @type {[2 | 4, number][]} */ ...numbers) => {
    for (const [size, x] of numbers) {
      if (size === 2) view.setUint16(at, x, true);
      else view.setUint32(at, x, true);
      at += size;
    }
  };
  const copy = (/** @type {Uint8Array} */ bytes) => {
    out.set(bytes, at);
    at += bytes.length;
  };
  /** Returns the fields that the local header and the directory entry of a file have in common. @returns {[2 | 4, number][]} */
  const common = (/** @type {typeof all[number]} */ { name, bytes, crc }) => [
    [2, 20], [2, UTF8], [2, 0], [2, 0], [2, DATE], [4, crc], [4, bytes.length], [4, bytes.length], [2, name.length], [2, 0],
  ];
  for (const file of all) {
    file.at = at;
    put([4, 0x04034b50], ...common(file));
    copy(file.name);
    copy(file.bytes);
  }
  const list = at;
  for (const file of all) {
    put([4, ENTRY], [2, 20], ...common(file), [2, 0], [2, 0], [2, 0], [4, 0], [4, file.at]);
    copy(file.name);
  }
  put([4, END], [2, 0], [2, 0], [2, all.length], [2, all.length], [4, at - list], [4, list], [2, 0]);
  return out;
}
