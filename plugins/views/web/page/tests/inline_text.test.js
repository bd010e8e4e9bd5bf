import assert from "node:assert/strict";
import { test } from "node:test";

import { partsOf } from "../lib/inline_text.js";

test("emphasis in texts of scenes", () => {
  const marked = (text) => partsOf(text).map((part) => `${part.tag}:${part.text}`);
  assert.deepEqual(marked("Key `w` saves."), [":Key ", "code:w", ": saves."]);
  assert.deepEqual(marked("*Open the script* below, **now**"), ["em:Open the script", ": below, ", "strong:now"]);
  assert.deepEqual(marked("2 * 3 * 4, a*b*c, *"), [":2 * 3 * 4, a*b*c, *"]);
  assert.deepEqual(marked(""), []);
});
