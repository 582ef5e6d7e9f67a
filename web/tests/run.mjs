// Runs the tests of the page: node tests/run.mjs [unit|browser]; without a word both. Ends with 0: they passed; 1: they
// failed; 77: they could not be run, and what is missing is said.

import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readdirSync, rmSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const root = join(dirname(fileURLToPath(import.meta.url)), "..");
const skipped = 77;

function skip(what) {
  console.log(`SKIPPED: ${what}`);
  process.exit(skipped);
}

if (!existsSync(join(root, "node_modules/esbuild"))) skip("the npm packages are missing: make web, or npm ci in web");
if (spawnSync("protoc", ["--version"]).status !== 0) skip("protoc is missing: apt-get install protobuf-compiler");

const wanted = process.argv[2] ? [process.argv[2]] : ["unit", "browser"];
for (const kind of wanted) {
  if (kind === "browser") {
    const { whatIsMissing } = await import("./browser.mjs");
    if (whatIsMissing() !== "") skip(whatIsMissing());
  }
  const folder = join(root, "tests", kind);
  let files = readdirSync(folder)
    .filter((file) => /\.test\.(ts|mjs)$/.test(file))
    .map((file) => join(folder, file));
  const built = join(root, "tests", ".build");
  if (kind === "unit") {
    // The sources are TypeScript: each test is bundled with what it tests.
    const { build } = await import("esbuild");
    rmSync(built, { recursive: true, force: true });
    mkdirSync(built);
    await build({
      entryPoints: files,
      outdir: built,
      outExtension: { ".js": ".mjs" },
      bundle: true,
      format: "esm",
      platform: "node",
      target: "node20",
      packages: "external",
      external: ["*/schemas.mjs", "*/world.mjs", "*/recorded.mjs", "*/build.mjs"],
      logLevel: "warning",
    });
    files = readdirSync(built)
      .filter((file) => file.endsWith(".test.mjs"))
      .map((file) => join(built, file));
  }
  const { status } = spawnSync(
    process.execPath,
    ["--test", "--test-concurrency=1", "--test-timeout=120000", ...files],
    { stdio: "inherit", cwd: root },
  );
  rmSync(built, { recursive: true, force: true });
  if (status !== 0) process.exit(1);
}
