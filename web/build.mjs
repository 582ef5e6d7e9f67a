// Bundles src/ into dist/: viewer.js, viewer.css, index.html, report.js, which stands in reports, and the licences of
// what is bundled. Nothing in dist/ depends on the machine it is made on.

import { build } from "esbuild";
import { mkdir, readFile, readdir, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const root = dirname(fileURLToPath(import.meta.url));

/** The text of a licence; some packages name theirs but do not carry it. */
async function licenceOf(name) {
  const folder = join(root, "node_modules", name);
  const { version, license } = JSON.parse(await readFile(join(folder, "package.json"), "utf8"));
  const file = (await readdir(folder)).find((entry) => /^licen[cs]e/i.test(entry));
  const text = await readFile(
    file ? join(folder, file) : join(root, "licenses", `${name.replace("/", "__")}.txt`),
    "utf8",
  );
  return `${"=".repeat(78)}\n${name} ${version}: ${license}\n\n${text.replaceAll("\r\n", "\n").trimEnd()}\n`;
}

/** The text of a bundle; the packages that are in it are added to `packages`. */
async function bundleOf(entry, outfile, packages) {
  const result = await build({
    absWorkingDir: root,
    entryPoints: [entry],
    outfile,
    write: false,
    bundle: true,
    format: "esm",
    target: "es2022",
    minify: true,
    legalComments: "none", // they stand in LICENSES.txt
    metafile: true,
    logLevel: "warning",
  });
  for (const input of Object.keys(result.metafile.inputs)) {
    const match = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
    if (match) packages.add(match[1]);
  }
  return result.outputFiles[0].text;
}

/** What belongs into dist/: texts by the files' names. */
export async function bundled() {
  const packages = new Set();
  const files = new Map();
  for (const [entry, file] of [
    ["src/main.ts", "viewer.js"],
    ["src/report/main.ts", "report.js"],
  ]) {
    files.set(file, await bundleOf(entry, `dist/${file}`, packages));
  }
  const licences = await Promise.all([...packages].sort().map(licenceOf));
  const head = "viewer.js and report.js contain these packages of npm, under their licences:\n";
  files.set("LICENSES.txt", [head, ...licences].join("\n"));
  for (const file of ["index.html", "viewer.css"]) files.set(file, await readFile(join(root, "static", file), "utf8"));
  return files;
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href) {
  await mkdir(join(root, "dist"), { recursive: true });
  for (const [name, text] of await bundled()) await writeFile(join(root, "dist", name), text);
}
