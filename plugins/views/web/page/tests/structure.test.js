import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const page = fileURLToPath(new URL("..", import.meta.url));
/** The folders, from the lowest to the highest. Modules import from their own folder and from lower ones. */
const FOLDERS = ["lib", "net", "scene", "view", "edit", "documents", "windows", "run", "panels", "film"];
/** The forms of imports: of a module, of a module that is loaded later, and of types. */
const IMPORT = /^import\b[^"(]*"([^"]+)"|\bimport\("([^"]+)"\)|@import [^"]*?"([^"]+)"/gm;

/** Returns the modules that a module imports, or whose types it uses, by their paths in the folder of the page. */
function importsOf(name) {
  const text = readFileSync(join(page, `${name}.js`), "utf8");
  const found = [...text.matchAll(IMPORT)].map(([, plain, later, type]) => plain ?? later ?? type);
  return found.flatMap((specifier) => {
    if (specifier.startsWith("tatu/")) return [specifier.slice("tatu/".length)];
    return specifier.startsWith(".") ? [join(dirname(name), specifier).replace(/\.js$/, "")] : [];
  });
}

const names = ["main", ...FOLDERS.flatMap((folder) => (
  readdirSync(join(page, folder)).filter((file) => file.endsWith(".js")).map((file) => `${folder}/${file.slice(0, -3)}`)
))];
const modules = new Map(names.map((name) => [name, importsOf(name).filter((other) => other !== "protocol")]));

test("every folder has a place in the order, and every import exists", () => {
  const folders = readdirSync(page, { withFileTypes: true }).filter((entry) => entry.isDirectory()).map((entry) => entry.name);
  assert.deepEqual(folders.filter((name) => name !== "node_modules" && name !== "tests").sort(), [...FOLDERS].sort());
  for (const [name, others] of modules) for (const other of others) assert.ok(modules.has(other), `${name} imports ${other}`);
  assert.ok(modules.get("main").length > 30);
});

test("modules import from their own folder and from lower ones", () => {
  const level = (name) => FOLDERS.indexOf(dirname(name));
  for (const [name, others] of modules) {
    if (name === "main") continue;
    for (const other of others) assert.ok(level(other) <= level(name), `${name} imports ${other}, which is in a higher folder`);
  }
});

test("imports have no cycles", () => {
  const done = new Set();
  const visit = (name, path) => {
    assert.ok(!path.includes(name), `a cycle: ${[...path, name].join(" -> ")}`);
    if (done.has(name)) return;
    for (const other of modules.get(name)) visit(other, [...path, name]);
    done.add(name);
  };
  for (const name of modules.keys()) visit(name, []);
});

test("films contain all modules that they import", () => {
  const source = readFileSync(join(page, "../src/film_page.rs"), "utf8");
  const list = (name) => [...(source.match(new RegExp(`const ${name}:[^;]*;`))?.[0] ?? "").matchAll(/"([a-z_]+\/[a-z_]+)"/g)].map(([, path]) => path);
  const shared = list("SHARED_MODULES");
  const replaced = list("REPLACED_MODULES");
  const there = new Set([...shared, ...replaced]);
  assert.ok(shared.includes("film/player"));
  for (const name of there) assert.ok(existsSync(join(page, `${name}.js`)), name);
  const own = [...shared, ...replaced.filter((_, i) => i % 2 === 1)];
  for (const name of own) {
    const text = readFileSync(join(page, `${name}.js`), "utf8");
    // Addresses of data cannot be the base of relative imports.
    for (const [, specifier] of text.matchAll(/^import\b[^"]*"([^"]+)"/gm)) {
      if (specifier.startsWith("three")) continue;
      assert.ok(specifier.startsWith("tatu/") && there.has(specifier.slice("tatu/".length)), `${name} imports ${specifier}`);
    }
  }
});

test("the readme names every module", () => {
  const text = readFileSync(join(page, "../README.md"), "utf8");
  for (const folder of FOLDERS) {
    const row = text.split("\n").find((line) => line.startsWith(`| \`${folder}/\``)) ?? "";
    const listed = [...row.matchAll(/`([a-z_]+)`/g)].map(([, name]) => name).sort();
    const own = names.filter((name) => dirname(name) === folder).map((name) => name.slice(folder.length + 1)).sort();
    assert.deepEqual(listed, own, `the row of ${folder} in README.md`);
  }
});

test("names are plain terms", () => {
  const obscure = /\b(?:const|let|function|class) (told|tell|said|say|who|how|kept|beside|wants?|wanted|felt|clad|going|gone|own|MOST\w*|FEW|MANY|OFTEN|PATIENCE|STILL|AGAIN|ROOM)\b/g;
  for (const name of names) {
    const found = [...readFileSync(join(page, `${name}.js`), "utf8").matchAll(obscure)].map(([, word]) => word);
    assert.deepEqual(found, [], `${name}: name these after what they are; call an upper bound MAX_...`);
  }
});
