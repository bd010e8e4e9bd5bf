// @ts-check
// Models that plugins offer, to add one where the camera looks.

import { failure } from "tatu/calls";
import { get, make } from "tatu/dom";
import { call } from "tatu/net";
import { changed, rights, scene, select, watch } from "tatu/store";
import { controls } from "tatu/view";
import { line } from "tatu/output";

const dialog = get("models-dialog", HTMLDialogElement);
const list = get("models");
let wanted = 0;

/** @param {string} id */
async function add(id) {
  dialog.close();
  try {
    const [made] = await call("tatu.addModel", id);
    const [place] = await call("tatu.get", made, "object.position");
    await call("tatu.set", made, "object.position", [controls.target.x, controls.target.y, place[2]]);
    changed();
    wanted = made;
    choose();
  } catch (e) {
    line("Status", failure(e).error, "error");
  }
}

/** The new model is selected once it is there. */
function choose() {
  if (!wanted || !scene.objects.has(wanted)) return;
  select(wanted);
  wanted = 0;
}
watch("scene", choose);

get("add-model").onclick = async () => {
  if (!rights.acts) return;
  /** @type {[{ id: string, text: string }[]]} */
  const [models] = /** @type {any} */ (await call("tatu.models"));
  list.replaceChildren(...models.map(({ id, text }) => {
    const li = make("li");
    const b = make("button", { className: "scene", onclick: () => add(id) });
    const name = document.createElement("strong");
    name.textContent = id;
    const small = document.createElement("small");
    small.textContent = text;
    b.append(name, small);
    li.append(b);
    return li;
  }));
  dialog.showModal();
};
