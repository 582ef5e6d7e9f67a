/** One way into the store for live channels and recordings: topic, type, schema, bytes. */

import { decoderOf, type Decode } from "../protobuf/schemas.js";
import { fieldsOf } from "../protobuf/fields.js";
import { splitTriangles } from "../protobuf/triangle_lists.js";
import { seconds } from "../time.js";
import { kFoxgloveHandlers } from "./foxglove.js";
import type { Handler, Handlers } from "./handler.js";
import { kCycleHandlers } from "./raw_cycle.js";
import { kPlanHandlers } from "./raw_plans.js";
import { kShapeHandlers } from "./raw_shapes.js";
import { kSignalHandlers } from "./raw_signals.js";
import { kStageHandlers } from "./raw_stage.js";
import type { Store } from "./store.js";

export interface Source {
  topic: string;
  schemaName: string;
  encoding: string;
}

const kHandlers: Handlers = {
  ...kFoxgloveHandlers,
  ...kShapeHandlers,
  ...kPlanHandlers,
  ...kSignalHandlers,
  ...kCycleHandlers,
  ...kStageHandlers,
};

/** A topic of well-known type that shows what messages of these types would: they are not read beside it. */
const kReplaced: Readonly<Record<string, string[]>> = {
  "/viewer/cloud": ["prehend.msgs.ObjectHypotheses"],
  "/viewer/robot": ["prehend.msgs.JointState"],
  "/viewer/objects": ["prehend.msgs.ObjectModel"],
  "/viewer/image/left": ["prehend.msgs.StereoPair", "prehend.msgs.Image", "prehend.msgs.DepthImage"],
  "/viewer/log": ["prehend.msgs.graph.LogLine"],
};

/** Types of which only the last message before a moment is worth reading. */
const kLatestOnly = new Set([
  "foxglove.PointCloud",
  "foxglove.RawImage",
  "foxglove.CompressedImage",
  "prehend.msgs.StereoPair",
  "prehend.msgs.Image",
  "prehend.msgs.DepthImage",
  "prehend.msgs.Clock",
  "prehend.msgs.EmergencyStop",
  "prehend.msgs.graph.NodeStatistics",
]);

/** Types of signals: worth reading for as long as a chart is wide. */
const kSignals = new Set([
  "prehend.msgs.TactileFrame",
  "prehend.msgs.Wrench",
  "prehend.msgs.GripperState",
  "prehend.msgs.JointState",
  "foxglove.FrameTransforms",
]);

export type Kind = "state" | "signal" | "latest";

export function kindOf(schemaName: string): Kind {
  if (kLatestOnly.has(schemaName)) return "latest";
  return kSignals.has(schemaName) ? "signal" : "state";
}

/** Whether a source is worth its traffic, given all that there are. */
export function isShown(source: Source, all: Iterable<Source>): boolean {
  const { topic, schemaName, encoding } = source;
  if (encoding !== "protobuf" || !Object.hasOwn(kHandlers, schemaName)) return false;
  // Models are published before and after what is known by touch; the last word is /models.
  if (schemaName === "prehend.msgs.ObjectModel" && topic !== "/models") return false;
  for (const other of all) {
    if (kReplaced[other.topic]?.includes(schemaName)) return false;
    // A pad's own frames have the calibrated sum, too.
    if (topic.startsWith("/viewer/pad/") && other.schemaName === "prehend.msgs.TactileFrame") return false;
  }
  return true;
}

/** Whether a source sends pictures: the most traffic of all, wanted only while somebody looks at them. */
export function isPicture({ topic, schemaName }: Source): boolean {
  return (
    /\.(RawImage|CompressedImage|StereoPair|Image|DepthImage)$/.test(schemaName) && !topic.startsWith("/viewer/pad/")
  );
}

export class Ingest {
  /** What could not be shown, in words; each once. */
  onTrouble: (text: string) => void = () => {};
  readonly #decoders = new Map<string, Decode | null>();
  readonly #troubles = new Set<string>();

  constructor(private readonly store: Store) {}

  /** `key` names the schema (a channel of this session, of this file); `schema` is read when it is new. */
  take(key: string, source: Source, schema: () => Uint8Array, time: bigint, data: Uint8Array): void {
    const handler: Handler | undefined = kHandlers[source.schemaName];
    if (!handler) return;
    try {
      const decode = this.#decoder(key, source.schemaName, schema);
      if (!decode) return;
      const arrival = { topic: source.topic, time: seconds(time) };
      if (source.schemaName === "foxglove.SceneUpdate") {
        const { rest, lists } = splitTriangles(data);
        handler(this.store, { ...arrival, fields: fieldsOf(decode(rest)), lists });
      } else {
        handler(this.store, { ...arrival, fields: fieldsOf(decode(data)) });
      }
    } catch (error) {
      this.#say(`${source.topic}: ${error instanceof Error ? error.message : String(error)}`);
    }
  }

  /** Another session, another file: keys mean other schemas. */
  reset(): void {
    this.#decoders.clear();
    this.#troubles.clear();
  }

  #decoder(key: string, name: string, schema: () => Uint8Array): Decode | null {
    const known = this.#decoders.get(key);
    if (known !== undefined) return known;
    this.#decoders.set(key, null); // a damaged schema is said once
    const decode = decoderOf(name, schema());
    this.#decoders.set(key, decode);
    return decode;
  }

  #say(text: string): void {
    if (this.#troubles.has(text) || this.#troubles.size > 200) return;
    this.#troubles.add(text);
    this.onTrouble(text);
  }
}
