// @ts-check
// The banner that explains why the page is not connected, and what to do.

import { get } from "tatu/lib/dom";
import { on } from "tatu/net/connection";

const banner = get("lost");
const here = location.host;
const WHY = {
  gone: `No program answers at ${here}. This page reconnects when Tatu is started again at this address: tatu open --port ${location.port}`,
  other: `Another program answers at ${here}. Open the address that Tatu prints.`,
  old: `The program rejects the token of this page, because this address is old. Open the address that the program prints.`,
};

on("lost", (why) => {
  // The text is set only if it changes, because screen readers announce each new text.
  if (banner.textContent !== WHY[why]) banner.textContent = WHY[why];
  banner.hidden = false;
});
on("connected", () => { banner.hidden = true; });
