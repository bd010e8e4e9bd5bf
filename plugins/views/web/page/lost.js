// @ts-check
// The banner that explains why there is no connection, and what to do.

import { get } from "tatu/dom";
import { on } from "tatu/net";

const banner = get("lost");
const here = location.host;
const WHY = {
  gone: `No program answers at ${here}. This page connects by itself when the program is started again there: tatu open --port ${location.port}`,
  other: `Another program answers at ${here}. Open the address that Tatu prints.`,
  old: `The program is there, but this address is old. Open the address that it prints.`,
};

on("lost", (why) => {
  // The text is only set if it has changed, because screen readers read each new text.
  if (banner.textContent !== WHY[why]) banner.textContent = WHY[why];
  banner.hidden = false;
});
on("connected", () => { banner.hidden = true; });
