/** The graph's own messages of what is felt and moved: pads, wrench, joints, clock, stop, health, log. */

import { child, children, integer64, number, numbers, text, truth, type Fields } from "../protobuf/fields.js";
import { seconds } from "../time.js";
import type { Handlers } from "./handler.js";
import type { Level, PadImage } from "./types.js";

const kLevels: Level[] = ["debug", "info", "warning", "error"];
const kMostPads = 64;

/** prehend.msgs.TactileFrame; null: it has no cells, or not as many as it says. */
export function tactileImage(fields: Fields): PadImage | null {
  const [rows, columns] = [number(fields, "rows"), number(fields, "columns")];
  const counts = numbers(fields, "intensity");
  if (rows * columns === 0 || counts.length !== rows * columns) return null;
  const newtonPerCount = number(fields, "newtonPerCount");
  const forces = Float32Array.from(counts, (count) => count * newtonPerCount);
  return { rows, columns, forces, sum: number(fields, "sum") };
}

function stampOf(fields: Fields, otherwise: number): number {
  const stamp = integer64(child(fields, "header"), "stamp");
  return stamp > 0n ? seconds(stamp) : otherwise;
}

export const kSignalHandlers: Handlers = {
  "prehend.msgs.TactileFrame": (store, { topic, time, fields }) => {
    const image = tactileImage(fields);
    const name = text(child(fields, "header"), "frameId") || topic;
    if (!image) throw new Error(`a frame of ${name} has other cells than rows and columns`);
    if (store.pads.size >= kMostPads && !store.pads.has(name)) return;
    store.pads.set(name, image);
    store.touch("pads");
    store.sample(`pad ${name}`, stampOf(fields, time), image.sum);
  },

  "prehend.msgs.Wrench": (store, { time, fields }) => {
    const at = stampOf(fields, time);
    const wrench = child(fields, "wrench");
    for (const [part, unit] of [
      ["force", "F"],
      ["torque", "T"],
    ] as const) {
      const vector = child(wrench, part);
      for (const axis of ["x", "y", "z"]) store.sample(`wrench ${unit}${axis}`, at, number(vector, axis));
    }
  },

  "prehend.msgs.GripperState": (store, { time, fields }) => {
    store.sample("gripper opening", stampOf(fields, time), number(fields, "opening"));
  },

  "prehend.msgs.Clock": (store, { fields }) => {
    store.time = seconds(integer64(fields, "time"));
    store.speed = number(fields, "speed");
    store.touch("clock");
  },

  "prehend.msgs.EmergencyStop": (store, { fields }) => {
    store.stop = {
      stopped: truth(fields, "stopped"),
      source: text(fields, "source"),
      reason: text(fields, "reason"),
      since: seconds(integer64(fields, "since")),
    };
    store.touch("stop");
  },

  "prehend.msgs.graph.Diagnostic": (store, { fields }) => {
    const node = text(fields, "node");
    if (store.diagnostics.size >= 500 && !store.diagnostics.has(node)) return;
    store.diagnostics.set(node, {
      time: seconds(integer64(fields, "stamp")),
      node,
      level: (["ok", "warning", "error"] as const)[number(fields, "level")] ?? "error",
      text: text(fields, "text"),
    });
    store.touch("diagnostics");
  },

  "prehend.msgs.graph.LogLine": (store, { fields }) => {
    store.addLog({
      time: seconds(integer64(fields, "stamp")),
      level: kLevels[number(fields, "level")] ?? "info",
      node: text(fields, "node"),
      text: text(fields, "text"),
    });
  },

  "prehend.msgs.graph.NodeStatistics": (store, { fields }) => {
    const node = text(fields, "node");
    const lost = children(fields, "topics").reduce(
      (sum, topic) => sum + number(topic, "dropped") + number(topic, "missed") + number(topic, "malformed"),
      number(fields, "malformedFrames"),
    );
    if (lost > 0 && !store.diagnostics.has(`${node} traffic`) && store.diagnostics.size < 500) {
      store.diagnostics.set(`${node} traffic`, {
        time: seconds(integer64(fields, "stamp")),
        node: `${node} traffic`,
        level: "warning",
        text: `${lost} messages were lost or damaged`,
      });
      store.touch("diagnostics");
    }
  },
};
