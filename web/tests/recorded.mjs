// The small world as a recording of the graph's own topics, as its recorder writes them.

import { McapWriter } from "@mcap/core";
import wasmZstd from "@foxglove/wasm-zstd";
import lz4 from "lz4js";
import { schemaOf } from "./schemas.mjs";
import * as world from "./world.mjs";

/** Bytes of an MCAP file; compression "", "zstd" or "lz4". */
export async function writeRecording({ compression = "", seconds = 15 } = {}) {
  await wasmZstd.isLoaded;
  const parts = [];
  let position = 0n;
  const writer = new McapWriter({
    writable: {
      position: () => position,
      write: async (bytes) => {
        parts.push(bytes.slice());
        position += BigInt(bytes.length);
      },
    },
    chunkSize: 40_000,
    ...(compression !== "" && {
      compressChunk: (data) => ({
        compression,
        compressedData: compression === "zstd" ? wasmZstd.compress(data, 3) : Uint8Array.from(lz4.compress(data)),
      }),
    }),
  });
  await writer.start({ profile: "", library: "tests" });
  const channels = new Map();
  const schemas = new Map();
  const add = async (time, topic, type, data) => {
    if (!schemas.has(type))
      schemas.set(type, await writer.registerSchema({ name: type, encoding: "protobuf", data: schemaOf(type) }));
    if (!channels.has(topic)) {
      channels.set(
        topic,
        await writer.registerChannel({
          topic,
          schemaId: schemas.get(type),
          messageEncoding: "protobuf",
          metadata: new Map(),
        }),
      );
    }
    const stamp = BigInt(Math.round(time * 1e9));
    await writer.addMessage({ channelId: channels.get(topic), sequence: 0, logTime: stamp, publishTime: stamp, data });
  };
  await add(0.5, "/objects", "prehend.msgs.ObjectHypotheses", world.hypotheses());
  for (const object of [0, 1, 2]) {
    await add(0.8, "/models", "prehend.msgs.ObjectModel", world.model(object));
    await add(1, "/plans", "prehend.msgs.GraspPlan", world.plan(object));
  }
  for (const data of world.diagnostics()) await add(1, "/diagnostics", "prehend.msgs.graph.Diagnostic", data);
  const events = world.eventsUntil(seconds);
  for (let time = 1; time <= seconds; time += 0.05) {
    while (events.length > 0 && events[0][0] <= time) await add(...events.shift());
    for (const [topic, type, data] of world.signalsAt(time)) await add(time, topic, type, data);
  }
  await writer.end();
  return new Uint8Array(Buffer.concat(parts));
}
