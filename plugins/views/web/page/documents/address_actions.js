// @ts-check
// Executes the actions in the fragment of the address when the first scene arrives: `select=NAME`, `script` and `play`,
// separated by `&`.

import { send } from "tatu/net/connection";
import { scene, select, watch } from "tatu/scene/store";
import { openScript } from "tatu/documents/script_editor";

const asked = new URLSearchParams(location.hash.slice(1));
let done = false;

watch("scene", () => {
  if (done || !scene.objects.size) return;
  done = true;
  const all = [...scene.objects.values()];
  const found = all.find((o) => o.alias === asked.get("select"));
  if (found) select(found.id);
  const script = all.find((o) => o.scripts?.length)?.scripts?.[0];
  if (asked.has("script") && script) openScript(script);
  if (asked.has("play")) send({ type: "run", action: "start" });
});
