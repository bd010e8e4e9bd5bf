// @ts-check
// The banner that explains why the page is not connected, and what to do.

import { get } from "tatu/lib/dom";
import { t } from "tatu/lib/language";
import { on } from "tatu/net/connection";

const banner = get("lost");
const address = location.host;
const REASONS = {
  gone: t`No program answers at ${address}. This page reconnects when Tatu is started again at this address: tatu open --port ${location.port}`,
  other: t`Another program answers at ${address}. Open the address that Tatu prints.`,
  old: t`The program rejects the token of this page, because this address is old. Open the address that the program prints.`,
};

on("lost", (reason) => {
  // The text is set only if it changes, because screen readers announce each new text.
  if (banner.textContent !== REASONS[reason]) banner.textContent = REASONS[reason];
  banner.hidden = false;
});
on("connected", () => { banner.hidden = true; });
