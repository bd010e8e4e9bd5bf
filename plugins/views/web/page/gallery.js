// Scenes that are here, to open one; and files that are dropped.

import { call, on, send, upload } from "tatu/net";
import { rights, scene, watch } from "tatu/store";
import { line } from "tatu/output";

const dialog = document.getElementById("dialog");
const files = document.getElementById("files");

export function browse() {
  send({ files: true });
  if (!dialog.open) dialog.showModal();
}

async function open(file) {
  if (dialog.open) dialog.close();
  try {
    await call("tatu.open", file);
  } catch (e) {
    line("Status", e.error, "error");
  }
}

function entry({ file, about, picture }) {
  const li = document.createElement("li");
  const b = document.createElement("button");
  b.className = "scene";
  b.onclick = () => open(file);
  if (picture) b.append(Object.assign(new Image(240, 150), { src: `data:image/png;base64,${picture}`, alt: "" }));
  const name = document.createElement("strong");
  name.textContent = file.split("/").pop().replace(/\.toml$/, "").replaceAll("_", " ");
  b.title = file;
  const small = document.createElement("small");
  small.textContent = about;
  b.append(name, small);
  li.append(b);
  return li;
}

on("files", (message) => {
  const none = document.createElement("li");
  none.textContent = "No scenes lie in the folder in which the program was started.";
  files.replaceChildren(...(message.files.length ? message.files.map(entry) : [none]));
});
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
