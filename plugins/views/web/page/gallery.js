// The gallery of scenes, to open one; and files that are dropped.

import { ask, call, on, send, upload } from "tatu/net";
import { sendPicture } from "tatu/pictures";
import { rights, scene, watch } from "tatu/store";
import { line } from "tatu/output";

const dialog = document.getElementById("dialog");
const files = document.getElementById("files");
const find = document.getElementById("find-scene");

export function browse() {
  // The list shows the open scene as it looks now.
  sendPicture();
  send({ files: true });
  find.value = "";
  if (!dialog.open) dialog.showModal();
}

async function open(file) {
  sendPicture();
  if (dialog.open) dialog.close();
  try {
    await ask({ open: file }, `opening ${file}`);
  } catch (e) {
    line("Status", e.help ? `${e.error} (${e.help})` : e.error, "error");
  }
}

/** What people call a scene: the name of its file; the demonstration of a model is named after the model. */
function title(file) {
  const parts = file.split(/[\\/]/);
  const last = parts.pop();
  const name = last === "demo.toml" && parts.length ? parts.pop() : last.replace(/\.toml$/, "");
  return name.replaceAll("_", " ");
}

function text(tag, content, className = "") {
  return Object.assign(document.createElement(tag), { textContent: content, className });
}

function card({ file, about, try: toTry, picture }) {
  const li = document.createElement("li");
  const b = document.createElement("button");
  b.className = "scene";
  b.onclick = () => open(file);
  b.title = file;
  if (picture) b.append(Object.assign(new Image(240, 150), { src: `data:image/png;base64,${picture}`, alt: "" }));
  b.append(text("strong", title(file)));
  if (about) b.append(text("small", about));
  if (toTry) b.append(text("small", `Try: ${toTry}`, "try"));
  li.append(b);
  return li;
}

/** A heading and its cards. */
function section(name, all) {
  const own = document.createElement("section");
  const list = document.createElement("ul");
  list.append(...all.map(card));
  own.append(text("h3", name), list);
  return own;
}

on("files", ({ files: all, folder }) => {
  const sections = [["recent", "Recent"], ["own", folder ? `Yours: ${folder}` : "Yours"], ["program", "Comes with Tatu"]];
  const shown = sections.map(([key, name]) => [name, all.filter((f) => f.in === key)]).filter(([, cards]) => cards.length);
  const none = text("p", shown.length ? "No scene is like this." : "There are no scenes here: drop one on the page.");
  none.id = "no-scene";
  files.replaceChildren(...shown.map(([name, cards]) => section(name, cards)), none);
  sift();
});

/** Shows the cards that contain each word that is looked for. */
function sift() {
  const words = find.value.toLowerCase().split(/\s+/);
  let any = false;
  for (const own of files.querySelectorAll("section")) {
    let some = false;
    for (const li of own.querySelectorAll("li")) {
      const name = `${li.textContent} ${li.firstChild.title}`.toLowerCase();
      li.hidden = !words.every((word) => name.includes(word));
      some ||= !li.hidden;
    }
    own.hidden = !some;
    any ||= some;
  }
  document.getElementById("no-scene").hidden = any;
}
find.oninput = () => { if (files.childElementCount) sift(); };
document.getElementById("gallery").onclick = browse;

let first = true;
watch("scene", () => {
  if (first && !scene.objects.size) browse();
  first = false;
});

/** A dropped model comes into the scene that is open, anything else is opened. */
async function take(file) {
  try {
    const name = await upload(file);
    if (/\.(ttm|urdf)$/i.test(name) && scene.objects.size) await call("sim.loadModel", name);
    else await open(name);
  } catch (e) {
    line("Status", e.error, "error");
  }
}

document.addEventListener("dragover", (e) => { if (rights.acts) e.preventDefault(); });
document.addEventListener("drop", (e) => {
  e.preventDefault();
  if (rights.acts) for (const file of e.dataTransfer.files) take(file);
});
const choose = document.getElementById("choose");
choose.onchange = () => {
  for (const file of choose.files) take(file);
  choose.value = "";
};
