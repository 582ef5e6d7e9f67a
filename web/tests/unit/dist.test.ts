import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
// @ts-expect-error: plain JavaScript
import { bundled } from "../../build.mjs";

const fresh = bundled as () => Promise<Map<string, string>>;

test("dist/ is what the sources give", async () => {
  for (const [name, text] of await fresh()) {
    assert.ok(readFileSync(`dist/${name}`, "utf8") === text, `dist/${name} is not of these sources: make web`);
  }
});

test("the document has no style, script or handler of its own, and names nothing elsewhere", () => {
  const page = readFileSync("dist/index.html", "utf8");
  assert.doesNotMatch(page, /<style|<script(?![^>]*src=)|\son\w+=|\sstyle=|https?:/i);
  const lock = readFileSync("package-lock.json", "utf8");
  for (const [, host] of lock.matchAll(/"resolved": "https?:\/\/([^/"]+)/g)) assert.equal(host, "registry.npmjs.org");
});
