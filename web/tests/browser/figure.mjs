// Figures of reports: a page of one, in a browser, and the colours that its canvas shows.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before } from "node:test";
import { pathToFileURL } from "node:url";
import { launch } from "../browser.mjs";

export const base64 = (array) => Buffer.from(array.buffer).toString("base64");

let browser;
let folder;
before(async () => {
  browser = await launch();
  folder = mkdtempSync(join(tmpdir(), "prehend-report-"));
});
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

/** Calls `body` with a page that has one figure, which is `kind` and has `data`; nothing may go wrong in it. */
export async function withFigure(kind, data, body) {
  const file = join(folder, "report.html");
  const program = readFileSync(new URL("../../dist/report.js", import.meta.url), "utf8");
  writeFileSync(
    file,
    `<!doctype html><body><figure class="${kind}"><script type="application/json">${JSON.stringify(data)}</script>` +
      `<figcaption>it</figcaption></figure><script type="module">${program}</script></body>`,
  );
  const page = await browser.newPage({ viewport: { width: 1000, height: 700 } });
  const wrong = [];
  page.on("pageerror", (error) => wrong.push(String(error)));
  page.on("request", (request) => {
    if (!/^(file|data|blob):/.test(request.url())) wrong.push(`it asked for ${request.url()}`);
  });
  try {
    await page.goto(pathToFileURL(file).href);
    await body(page);
    assert.deepEqual(wrong, []);
  } finally {
    await page.close();
  }
}

/** Rows of the canvas, mean and count, of pixels that are mostly of a colour: 0 red, 1 green, 2 blue. */
export const pixels = (page, channel) =>
  page.evaluate(async (wanted) => {
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    const canvas = document.querySelector("canvas");
    const context = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
    context.drawImage(canvas, 0, 0);
    const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
    let [count, rows] = [0, 0];
    for (let i = 0; i < data.length; i += 4) {
      const others = [0, 1, 2].filter((k) => k !== wanted).map((k) => data[i + k]);
      if (data[i + wanted] < 60 || Math.max(...others) > 0.5 * data[i + wanted]) continue;
      count++;
      rows += Math.floor(i / 4 / canvas.width);
    }
    return { count, row: rows / Math.max(1, count) };
  }, channel);
