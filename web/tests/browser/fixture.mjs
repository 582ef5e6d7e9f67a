// One browser for all tests of a file; a server and a page for each.

import { after, before } from "node:test";
import { launch } from "../browser.mjs";
import { populate } from "../demo.mjs";
import { TestServer } from "../server.mjs";

let browser;

export function useBrowser() {
  before(async () => {
    browser = await launch();
  });
  after(async () => {
    await browser?.close();
  });
}

/** Runs `body` with a page that shows the small world. Fails when the page threw, or loaded anything from elsewhere. */
export async function withPage(
  body,
  { viewport = { width: 1280, height: 860 }, colorScheme = "light", world = true, connect = true, ...options } = {},
) {
  const server = new TestServer();
  const step = world ? populate(server) : () => {};
  const port = await server.start();
  const context = await browser.newContext({ viewport, colorScheme, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(30_000);
  const wrong = [];
  page.on("pageerror", (error) => wrong.push(error.stack ?? String(error)));
  page.on("console", (message) => {
    if (message.type() === "error" && !/WebSocket connection|ERR_CONNECTION_REFUSED/.test(message.text()))
      wrong.push(message.text());
  });
  page.on("request", (request) => {
    const { hostname, protocol } = new URL(request.url());
    if (hostname !== "127.0.0.1" && protocol !== "data:" && protocol !== "blob:")
      wrong.push(`it asked for ${request.url()}`);
  });
  const stage = { server, page, step, port, wrong };
  try {
    await page.goto(`http://127.0.0.1:${port}/`);
    if (connect && world)
      await page.waitForFunction(() => window.prehend?.store.plans.size === 3 && window.prehend.store.cloud !== null);
    await body(stage);
    if (wrong.length > 0) throw new Error(`the page complained:\n${wrong.join("\n")}`);
  } finally {
    await context.close();
    await stage.server.stop().catch(() => {});
  }
}

/** Shares of the pixels of an element by hue: green, blue, orange, ..., and what is too grey to have one. */
export async function hues(page, selector = "#view") {
  // What changed is drawn: at once, in case the page waits because it drew only just before.
  await page.evaluate(
    () =>
      new Promise((resolve) =>
        requestAnimationFrame(() =>
          requestAnimationFrame(() => {
            window.prehend.viewport.drawNow();
            requestAnimationFrame(resolve);
          }),
        ),
      ),
  );
  const image = await page.locator(selector).screenshot({ timeout: 60_000 });
  return page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    const counts = { red: 0, orange: 0, yellow: 0, green: 0, cyan: 0, blue: 0, purple: 0, grey: 0 };
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b] = [data[i], data[i + 1], data[i + 2]];
      const [most, least] = [Math.max(r, g, b), Math.min(r, g, b)];
      if (most - least < 0.4 * most) {
        counts.grey++;
        continue;
      }
      const third =
        most === r
          ? (g - b) / (most - least)
          : most === g
            ? 2 + (b - r) / (most - least)
            : 4 + (r - g) / (most - least);
      const hue = (60 * third + 360) % 360;
      const name =
        hue < 18 || hue > 340
          ? "red"
          : hue < 46
            ? "orange"
            : hue < 75
              ? "yellow"
              : hue < 160
                ? "green"
                : hue < 195
                  ? "cyan"
                  : hue < 245
                    ? "blue"
                    : "purple";
      counts[name]++;
    }
    return counts;
  }, image.toString("base64"));
}

/** Waits until `check` is true of what the server holds; ends with an Error in words after 10 s. */
export async function eventually(check, what) {
  const end = performance.now() + 10_000;
  while (!check()) {
    if (performance.now() > end) throw new Error(`${what} did not happen within 10 s`);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

/** Only these layers of the 3-D view are shown. */
export async function showOnly(page, ...layers) {
  for (const box of await page.locator("#layers input").all()) {
    await box.setChecked(layers.includes(await box.getAttribute("data-layer")));
  }
}
