// @ts-check
// Sends files to the program: those that are dropped on the page, and those that are chosen in a dialog. The files of a
// folder, a selection or a zip archive are sent together, and the scene among them is opened.

import { choose } from "tatu/lib/dialogs";
import { get, make } from "tatu/lib/dom";
import { mark, t } from "tatu/lib/language";
import { unzip } from "tatu/lib/zip";
import { ask, call, upload, withRetries } from "tatu/net/connection";
import { edit, newMergeKey } from "tatu/scene/edits";
import { reportError, writeLine } from "tatu/scene/messages";
import { subtree } from "tatu/scene/hierarchy";
import { rights, scene, selectWhenPresent, watch, whenPresent } from "tatu/scene/store";
import { placeForFile, placementCall } from "tatu/edit/placement";
import { openScene } from "tatu/documents/gallery";
import { mayClose } from "tatu/documents/scene_file";

/** @import { Pointer } from "tatu/view/picking" */
/** @typedef {{ name: string, file: File }} Incoming A file; the name includes the folders that contain it. */

/** Extensions of files that are sent together with a scene; other files are ignored. */
const ACCEPTED = /\.(toml|ttt|ttm|urdf|xacro|sdf|world|xml|mjcf|config|ya?ml|lua|obj|mtl|stl|ply|dae|gltf|glb|bin|msh|png|jpe?g|svg|csv|json|txt|md)$/i;
/** Extensions of files that can be opened as a scene. */
const OPENABLE = /\.(toml|ttt|urdf|sdf|world|mjcf)$/i;
/** Extensions of files that may be a robot, or only a part of one: their contents decide. */
const PERHAPS_OPENABLE = /\.(xml|xacro)$/i;
/** The start of a robot or a world in XML. */
const ROBOT = /<(mujoco|robot|sdf)[\s>]/;
/** Extensions of files that can be sent on their own. */
const STANDALONE = /\.(toml|ttt|ttm|urdf|xacro|sdf|world|xml|mjcf|obj|stl|ply|dae|gltf|glb)$/i;
/** Extensions of files that are added to the open scene, if there is one. */
const MODEL = /\.(ttm|urdf|xacro|obj|stl|ply|dae|gltf|glb)$/i;
/** Extensions of meshes, each of which becomes a shape. */
const MESH = /\.(obj|stl|ply|dae|gltf|glb)$/i;
/** Number of bytes in which the first element of a robot's file is expected. */
const HEAD_BYTES = 8192;
/** Maximum number of files that are sent together; the program enforces the same limit. */
const MAX_FILES = 1000;

/**
 * Returns all files of a dropped file or folder, except hidden ones.
 * @param {FileSystemEntry} entry
 * @param {string} above path of the folder that contains the entry, ending with a slash
 * @returns {Promise<Incoming[]>}
 */
async function filesBelow(entry, above) {
  const name = above + entry.name;
  if (entry.isFile) {
    const file = await new Promise((/** @type {(file: File) => void} */ resolve, reject) => /** @type {FileSystemFileEntry} */ (entry).file(resolve, reject));
    return [{ name, file }];
  }
  const reader = /** @type {FileSystemDirectoryEntry} */ (entry).createReader();
  /** @type {Incoming[]} */
  const all = [];
  for (;;) {
    const batch = await new Promise((/** @type {(entries: FileSystemEntry[]) => void} */ resolve, reject) => reader.readEntries(resolve, reject));
    // `readEntries` returns the entries of a folder in batches; an empty batch ends them.
    if (!batch.length) return all;
    for (const one of batch) if (!one.name.startsWith(".")) all.push(...await filesBelow(one, `${name}/`));
    if (all.length > MAX_FILES) throw { error: t`\`${entry.name}\` has more than ${MAX_FILES} files` };
  }
}

/**
 * Replaces a single zip archive by the files in it.
 * @param {Incoming[]} files
 * @returns {Promise<Incoming[]>}
 */
async function unpackZip(files) {
  const [only] = files;
  if (files.length !== 1 || !only || !/\.zip$/i.test(only.name)) return files;
  const found = await unzip(await only.file.arrayBuffer(), (name) => ACCEPTED.test(name) && !/(^|\/)[._]/.test(name));
  return found.map(({ name, bytes }) => ({ name, file: new File([bytes], name.split("/").pop() ?? name) }));
}

/**
 * Returns a promise of the names of the files that can be opened: scenes, and without one, robots in files of other kinds.
 * @param {string[]} names
 * @param {Incoming[]} files
 */
async function openable(names, files) {
  const scenes = names.filter((name) => OPENABLE.test(name) && !/(^|\/)model\.toml$/i.test(name));
  if (scenes.length) return scenes;
  const robots = [];
  for (const [i, { file }] of files.entries()) {
    const name = names[i] ?? "";
    if (PERHAPS_OPENABLE.test(name) && ROBOT.test(await file.slice(0, HEAD_BYTES).text())) robots.push(name);
  }
  return robots;
}

/**
 * Returns a promise of the path of the scene to be opened, or of null if there is none or the user cancels. Of all
 * scenes except `model.toml`, those in the topmost folder are considered. If there are several, returns `scene.toml` or
 * the one that the user chooses.
 * @param {string[]} names
 * @param {Incoming[]} files
 */
async function sceneOf(names, files) {
  const scenes = await openable(names, files);
  const depth = (/** @type {string} */ name) => name.split("/").length;
  const topDepth = Math.min(...scenes.map(depth));
  const topScenes = scenes.filter((name) => depth(name) === topDepth);
  const defaultScenes = topScenes.filter((name) => /(^|\/)scene\.toml$/i.test(name));
  if (defaultScenes.length === 1 || topScenes.length < 2) return defaultScenes[0] ?? topScenes[0] ?? null;
  const chosen = await choose(mark("Which scene should be opened?"), [make("p", { textContent: t`There are several scenes.` })], [...topScenes, mark("Cancel")]);
  return topScenes.includes(chosen) ? chosen : null;
}

/**
 * Adds a model or a mesh to the open scene, or to a new scene if none is open, and says what was added. In an open scene it
 * is put on the surface at which the file was dropped.
 * @param {string} path
 * @param {Pointer} [at] where the file was dropped
 */
async function addToScene(path, at) {
  const name = path.split("/").pop()?.replace(/\.\w+$/, "") ?? path;
  // The point is determined without the new object, which may be anywhere.
  const place = at && scene.objects.size ? placeForFile(at) : null;
  if (!scene.objects.size) {
    // The scene may arrive before the answer does.
    const arrival = new Promise((/** @type {(value?: undefined) => void} */ resolve) => { afterNextScene = resolve; });
    await call("tatu.newScene");
    await arrival;
  }
  const merge = newMergeKey();
  const [[created] = []] = await edit(t`Add ${name}`, [["sim.loadModel", path]], merge);
  // The shape of a mesh has the name of its file. The object may arrive before its name does.
  const ownAlias = MESH.test(path) ? name.replace(/\W/g, "_") : null;
  if (ownAlias !== null) await edit(t`Add ${name}`, [["tatu.set", created, "object.alias", ownAlias]], merge);
  await whenPresent(created);
  if (place) await edit(t`Add ${name}`, [placementCall(created, place, ownAlias !== null)], merge);
  selectWhenPresent([created]);
  const alias = ownAlias ?? scene.objects.get(created)?.alias ?? name;
  const count = subtree(created).length;
  writeLine("Status", count > 1 ? t`Added ${alias}: ${count} objects` : t`Added ${alias}`);
}
/** Called when the program has sent a scene with objects. @type {(() => void) | null} */
let afterNextScene = null;
watch("scene", () => {
  if (!scene.objects.size) return;
  afterNextScene?.();
  afterNextScene = null;
});

/**
 * Sends files together, and opens the scene among them.
 * @param {Incoming[]} all
 * @param {string} title name of the folder or archive, for messages
 * @param {Pointer} [at] where they were dropped
 */
async function sendTogether(all, title, at) {
  const files = all.filter(({ name }) => ACCEPTED.test(name));
  if (files.length > MAX_FILES) throw { error: t`${title} has more than ${MAX_FILES} files` };
  // A top-level folder that contains all files is removed from their paths.
  const parts = files.map(({ name }) => name.split("/"));
  const topFolder = parts[0]?.[0] ?? "";
  const hasTopFolder = parts.every((p) => p.length > 1 && p[0] === topFolder);
  const names = parts.map((p) => (hasTopFolder ? p.slice(1) : p).join("/"));
  const chosenScene = await sceneOf(names, files);
  // A mesh may have files beside it, such as materials and images.
  const onlyMeshes = names.filter((name) => MESH.test(name));
  const mesh = chosenScene === null && onlyMeshes.length === 1 ? onlyMeshes[0] : undefined;
  if (chosenScene === null && mesh === undefined) throw { error: t`${title} cannot be opened: it contains no scene`, help: t`names of scene files end with .toml or .ttt, those of robots with .urdf, .xacro, .sdf, .world, .mjcf or .xml` };
  if (mesh === undefined && !(await mayClose())) return;
  const folderName = (hasTopFolder ? topFolder : title).replace(/\.zip$/i, "").replace(/[^\p{L}\p{N} ._()+-]/gu, "_").replace(/^\.+/, "");
  // The program links the folder to the connection, so after a loss, all files are sent again.
  const [folder, opened] = await withRetries(async () => {
    const [created] = await ask({ type: "folder", name: folderName || "scene" }, `the folder ${title}`);
    let scenePath = "";
    for (const [i, { file }] of files.entries()) {
      const name = names[i] ?? "";
      const path = await upload(file, name, created);
      if (name === (chosenScene ?? mesh)) scenePath = path;
    }
    return [created, scenePath];
  });
  writeLine("Status", t`${files.length} files are in ${folder}`);
  if (mesh === undefined) await openScene(opened, true);
  else await addToScene(opened, at);
}

/**
 * Sends a single file. Adds it to the open scene if it is a mesh or a model, otherwise opens it.
 * @param {Incoming} incoming
 * @param {Pointer} [at] where it was dropped
 */
async function sendOne({ name, file }, at) {
  const isModel = MESH.test(name) || (MODEL.test(name) && scene.objects.size > 0);
  if (!isModel && !(await mayClose())) return;
  const path = await withRetries(() => upload(file));
  if (isModel) await addToScene(path, at);
  else await openScene(path, true);
}

/**
 * Sends dropped or chosen files.
 * @param {Incoming[]} files
 * @param {Pointer} [at] where they were dropped
 */
async function sendFiles(files, at) {
  if (!rights.canControl || !files.length) return;
  try {
    const [only] = files;
    const all = await unpackZip(files);
    if (all.length === 1 && all === files && only && STANDALONE.test(only.name)) await sendOne(only, at);
    else await sendTogether(all, files.length === 1 ? only?.name ?? "" : (only?.name.split("/")[0] ?? "files"), at);
  } catch (thrown) {
    reportError(thrown);
  }
}

document.addEventListener("dragover", (e) => { if (rights.canControl) e.preventDefault(); });
document.addEventListener("drop", async (e) => {
  e.preventDefault();
  // The entries can be read only while the event is being handled.
  const entries = [...(e.dataTransfer?.items ?? [])].flatMap((item) => item.webkitGetAsEntry() ?? []);
  try {
    sendFiles((await Promise.all(entries.map((entry) => filesBelow(entry, "")))).flat(), { clientX: e.clientX, clientY: e.clientY });
  } catch (thrown) {
    reportError(thrown);
  }
});
for (const id of ["choose", "choose-folder"]) {
  const field = get(id, HTMLInputElement);
  field.onchange = () => {
    const files = [...(field.files ?? [])].map((file) => ({ name: file.webkitRelativePath || file.name, file }));
    field.value = "";
    get("dialog", HTMLDialogElement).close();
    sendFiles(files.filter(({ name }) => !/(^|\/)\./.test(name)));
  };
}
