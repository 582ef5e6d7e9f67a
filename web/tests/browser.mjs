// Debian's Chromium without a screen, with WebGL in software, and what is missing to run it.

import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

export const executable = "/usr/bin/chromium";

/** Why browser tests cannot run here; empty: they can. */
export function whatIsMissing() {
  return existsSync(executable) ? "" : `${executable} is missing: apt-get install chromium`;
}

export function launch() {
  return chromium.launch({
    executablePath: executable,
    timeout: 60_000,
    args: [
      "--headless",
      "--no-sandbox",
      "--disable-gpu",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
      "--use-gl=angle",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
    ],
  });
}
