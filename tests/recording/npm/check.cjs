// node check.cjs read FILE [--crc]   prints what @mcap/core's indexed reader finds, as JSON
// node check.cjs stream FILE         prints what its stream reader finds, as JSON
// node check.cjs views FILE          fails where a foxglove type has other fields than @foxglove/schemas
//                                    or a message of one cannot be decoded; prints them by topic
// node check.cjs write FILE          writes a recording with @mcap/core's writer
"use strict";
const fs = require("fs");
const { McapIndexedReader, McapStreamReader, McapWriter } = require("@mcap/core");
const { loadDecompressHandlers } = require("@mcap/support");
const protobuf = require("protobufjs");
const descriptor = require("protobufjs/ext/descriptor");

const print = (value) => console.log(JSON.stringify(value, (_, field) => typeof field === "bigint" ? field.toString() : field));

async function read(path) {
  const bytes = fs.readFileSync(path);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) =>
      new Uint8Array(bytes.subarray(Number(offset), Number(offset + length))),
  };
  const reader = await McapIndexedReader.Initialize({
    readable, decompressHandlers: await loadDecompressHandlers() });
  const topics = {};
  let ordered = true, last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    const root = protobuf.Root.fromDescriptor(descriptor.FileDescriptorSet.decode(schema.data));
    const type = root.lookupType(schema.name);
    const topic = (topics[channel.topic] ??= { count: 0, first: message.logTime, values: [],
                                               schema: schema.name });
    topic.count += 1;
    topic.last = message.logTime;
    topic.lastSequence = message.sequence;
    const value = type.toObject(type.decode(message.data), { longs: String, bytes: String });
    if (topic.values.length < 3) topic.values.push(value);
    ordered = ordered && message.logTime >= last;
    last = message.logTime;
  }
  const attachments = [];
  for await (const attachment of reader.readAttachments()) {
    attachments.push({ name: attachment.name, mediaType: attachment.mediaType,
                       text: new TextDecoder().decode(attachment.data) });
  }
  const metadata = [];
  for await (const item of reader.readMetadata()) {
    metadata.push({ name: item.name, entries: Object.fromEntries(item.metadata) });
  }
  print({ topics, ordered, attachments, metadata, chunks: reader.chunkIndexes.length,
          compressions: [...new Set(reader.chunkIndexes.map((chunk) => chunk.compression))],
          messageCount: reader.statistics.messageCount });
}

async function stream(path) {
  const reader = new McapStreamReader({ decompressHandlers: await loadDecompressHandlers(),
                                        validateCrcs: true });
  reader.append(fs.readFileSync(path));
  const types = {};
  for (let record; (record = reader.nextRecord());) {
    types[record.type] = (types[record.type] ?? 0) + 1;
  }
  print({ types, done: reader.done() });
}

async function views(path) {
  const publicSchemas = require("@foxglove/schemas/jsonschema");
  const bytes = fs.readFileSync(path);
  const reader = await McapIndexedReader.Initialize({
    readable: { size: async () => BigInt(bytes.length),
                read: async (offset, length) =>
                  new Uint8Array(bytes.subarray(Number(offset), Number(offset + length))) },
    decompressHandlers: await loadDecompressHandlers() });
  const plain = (name) => name.toLowerCase().replace(/_/g, "");
  const types = new Map(), counts = {}, problems = [];
  for (const schema of reader.schemasById.values()) {
    const root = protobuf.Root.fromDescriptor(descriptor.FileDescriptorSet.decode(schema.data));
    types.set(schema.id, root.lookupType(schema.name));
    if (!schema.name.startsWith("foxglove.")) continue;
    for (const nested of root.lookup("foxglove").nestedArray) {
      if (!(nested instanceof protobuf.Type)) continue;
      const ours = nested.fieldsArray.map((field) => plain(field.name)).sort().join();
      const theirs = Object.keys(publicSchemas[nested.name].properties).map(plain).sort().join();
      if (ours !== theirs) problems.push(`${nested.name}: ${ours} / ${theirs}`);
    }
  }
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    if (!reader.schemasById.get(channel.schemaId).name.startsWith("foxglove.")) continue;
    types.get(channel.schemaId).decode(message.data);
    counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  }
  if (problems.length) throw new Error(problems.join("; "));
  print(counts);
}

async function write(path) {
  const chunks = [];
  let position = 0;
  const writable = {
    position: () => BigInt(position),
    write: async (bytes) => { chunks.push(Uint8Array.from(bytes)); position += bytes.length; },
  };
  const writer = new McapWriter({ writable, chunkSize: 4096 });
  await writer.start({ profile: "", library: "npm" });
  const { root } = protobuf.parse('syntax = "proto3"; package t; message P { double x = 1; }');
  const type = root.lookupType("t.P");
  const set = descriptor.FileDescriptorSet.encode(root.toDescriptor("proto3")).finish();
  const schemaId = await writer.registerSchema({ name: "t.P", encoding: "protobuf", data: set });
  const channelId = await writer.registerChannel({ topic: "/npm", schemaId,
    messageEncoding: "protobuf", metadata: new Map([["key", "value"]]) });
  for (let i = 0; i < 500; ++i) {
    await writer.addMessage({ channelId, sequence: i + 1, logTime: BigInt(i) * 1000n,
      publishTime: BigInt(i), data: type.encode(type.create({ x: i * 0.5 })).finish() });
  }
  await writer.addAttachment({ name: "a.txt", logTime: 5n, createTime: 6n,
    mediaType: "text/plain", data: new TextEncoder().encode("attached") });
  await writer.addMetadata({ name: "run", metadata: new Map([["seed", "7"]]) });
  await writer.end();
  fs.writeFileSync(path, Buffer.concat(chunks));
}

const [action, path] = process.argv.slice(2);
({ read, stream, views, write })[action](path).catch((error) => {
  console.error(String(error));
  process.exit(1);
});
