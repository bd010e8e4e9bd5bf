// @ts-check
// Executes the actions in the fragment of the address when the first scene arrives: `select=NAME`, `script` and `play`,
// separated by `&`.

import { send } from "tatu/net/connection";
import { scene, select, watch } from "tatu/scene/store";
import { openScript } from "tatu/documents/script_editor";

const requests = new URLSearchParams(location.hash.slice(1));
let isDone = false;

watch("scene", () => {
  if (isDone || !scene.objects.size) return;
  isDone = true;
  const all = [...scene.objects.values()];
  const found = all.find((o) => o.alias === requests.get("select"));
  if (found) select(found.id);
  const script = all.find((o) => o.scripts?.length)?.scripts?.[0];
  if (requests.has("script") && script) openScript(script);
  if (requests.has("play")) send({ type: "run", action: "start" });
});
