// Bundles src/ into dist/: viewer.js, viewer.css, index.html and the licences of what is bundled. Nothing in dist/ depends
// on the machine it is made on.

import { build } from "esbuild";
import { copyFile, mkdir, readFile, readdir, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const root = dirname(fileURLToPath(import.meta.url));
const dist = join(root, "dist");

await mkdir(dist, { recursive: true });
const result = await build({
  absWorkingDir: root,
  entryPoints: ["src/main.ts"],
  outfile: "dist/viewer.js",
  bundle: true,
  format: "esm",
  target: "es2022",
  minify: true,
  legalComments: "none", // they stand in LICENSES.txt
  metafile: true,
  logLevel: "warning",
});
for (const file of ["index.html", "viewer.css"]) await copyFile(join(root, "static", file), join(dist, file));

const packages = new Set();
for (const input of Object.keys(result.metafile.inputs)) {
  const match = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
  if (match) packages.add(match[1]);
}
const parts = ["viewer.js contains these packages of npm, under their licences:\n"];
for (const name of [...packages].sort()) {
  const folder = join(root, "node_modules", name);
  const { version, license } = JSON.parse(await readFile(join(folder, "package.json"), "utf8"));
  const file = (await readdir(folder)).find((entry) => /^licen[cs]e/i.test(entry));
  // Some packages name their licence but do not carry its text.
  const text = await readFile(file ? join(folder, file) : join(root, "licenses", `${name.replace("/", "__")}.txt`), "utf8");
  parts.push(`${"=".repeat(78)}\n${name} ${version}: ${license}\n\n${text.replaceAll("\r\n", "\n").trimEnd()}\n`);
}
await writeFile(join(dist, "LICENSES.txt"), parts.join("\n"));
