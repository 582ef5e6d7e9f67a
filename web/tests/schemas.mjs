// Message types of the tests, from the .proto files by protoc: the schema sets that a server advertises, and encoders.

import { create, createFileRegistry, fromBinary, toBinary } from "@bufbuild/protobuf";
import { FileDescriptorSetSchema } from "@bufbuild/protobuf/wkt";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const tree = join(here, "../..");

function compiled(folder, files) {
  const scratch = mkdtempSync(join(tmpdir(), "prehend-web-"));
  try {
    const out = join(scratch, "set");
    execFileSync("protoc", [`-I${folder}`, "--include_imports", `--descriptor_set_out=${out}`, ...files], {
      cwd: folder,
    });
    return readFileSync(out);
  } finally {
    rmSync(scratch, { recursive: true });
  }
}

const sets = {
  foxglove: compiled(here, ["foxglove.proto"]),
  prehend: compiled(
    tree,
    readdirSync(join(tree, "msgs"))
      .filter((file) => file.endsWith(".proto"))
      .map((file) => `msgs/${file}`),
  ),
};
const registries = Object.fromEntries(
  Object.entries(sets).map(([name, set]) => [name, createFileRegistry(fromBinary(FileDescriptorSetSchema, set))]),
);

/** The serialised FileDescriptorSet that defines a message type. */
export function schemaOf(name) {
  return sets[name.split(".")[0]];
}

/**
 * Bytes of a message: `encode("prehend.msgs.Wrench", { wrench: { force: { x: 1 } } })`. Throws on a field of no such
 * name.
 */
export function encode(name, value) {
  const type = registries[name.split(".")[0]].getMessage(name);
  if (!type) throw new Error(`no message ${name}`);
  for (const key of Object.keys(value)) {
    if (!type.members.some((member) => member.localName === key)) throw new Error(`${name} has no ${key}`);
  }
  return toBinary(type, create(type, value));
}
