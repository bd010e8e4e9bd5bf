// Scenes that are here, to open one.

import { call, on, send } from "tatu/net";
import { scene, watch } from "tatu/store";
import { line } from "tatu/output";

const dialog = document.getElementById("dialog");
const files = document.getElementById("files");

export function browse() {
  send({ files: true });
  if (!dialog.open) dialog.showModal();
}

async function open(file) {
  dialog.close();
  try {
    await call("tatu.open", file);
  } catch (e) {
    line("Status", e.error, "error");
  }
}

on("files", (message) => {
  const entry = ({ file, about }) => {
    const li = document.createElement("li");
    const b = document.createElement("button");
    b.textContent = file;
    b.onclick = () => open(file);
    const small = document.createElement("small");
    small.textContent = about;
    li.append(b, small);
    return li;
  };
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
