/** The graph's own messages of what is done: phases, task, result, surprise. */

import { children, integer64, child, number, text, texts, truth, type Fields } from "../protobuf/fields.js";
import { seconds } from "../time.js";
import type { Handlers } from "./handler.js";

/** CycleState.Phase of grasp.proto. */
const kPhases = ["?", "waiting", "spawn", "approach", "grasp", "lift", "move", "release", "done", "failed", "push"];
const kOutcomes = ["failed", "ungraspable", "succeeded"];

/** Surprise.Kind of grasp.proto: in words, and the unit. */
const kKinds: [words: string, unit: string][] = [
  ["opening at contact", "m"],
  ["contact area", "m²"],
  ["tactile sum", "N"],
  ["held after lift", ""],
  ["touched too early", "N"],
  ["fingers touch", ""],
  ["fingers at contact", "rad"],
  ["lifted weight", "N"],
  ["held while carried", ""],
  ["placed", ""],
  ["motion", ""],
  ["slip", "m"],
];

function quantity(value: number, unit: string): string {
  if (unit === "") return value >= 0.5 ? "yes" : "no";
  if (unit === "m") return `${(1000 * value).toFixed(1)} mm`;
  if (unit === "m²") return `${(1e6 * value).toFixed(0)} mm²`;
  return `${value.toFixed(2)} ${unit}`;
}

function stampOf(fields: Fields, otherwise: number): number {
  const stamp = integer64(child(fields, "header"), "stamp");
  return stamp > 0n ? seconds(stamp) : otherwise;
}

export const kCycleHandlers: Handlers = {
  "prehend.msgs.CycleState": (store, { time, fields }) => {
    store.addPhase({
      time: stampOf(fields, time),
      phase: kPhases[number(fields, "phase")] ?? "?",
      detail: text(fields, "detail"),
      object: number(fields, "objectId"),
      grasp: number(fields, "graspIndex"),
    });
    store.taskState = text(fields, "taskState");
    store.touch("cycle");
  },

  "prehend.msgs.Task": (store, { fields }) => {
    store.taskStates = children(fields, "states").map((state) => text(state, "name"));
    store.touch("cycle");
  },

  "prehend.msgs.CycleResult": (store, { fields }) => {
    const path = texts(fields, "taskPath").at(-1);
    const outcome = kOutcomes[number(fields, "outcome")] ?? "failed";
    store.result = `${outcome}: ${text(fields, "reason") || path || "no reason given"}`;
    store.touch("cycle");
  },

  "prehend.msgs.Surprise": (store, { time, fields }) => {
    const [words, unit] = kKinds[number(fields, "kind")] ?? ["?", " "];
    store.addSurprise({
      time: stampOf(fields, time),
      name: words,
      predicted: quantity(number(fields, "predicted"), unit),
      felt: quantity(number(fields, "felt"), unit),
      surprising: truth(fields, "surprising"),
      reaction: text(fields, "reaction"),
    });
  },

  // Its header has the stamp of the view; when it was felt is when it was published.
  "prehend.msgs.PerceptSurprise": (store, { time, fields }) => {
    const bits = number(fields, "bits");
    const alarmed = children(fields, "senses").filter((sense) => truth(sense, "alarm"));
    store.addSurprise({
      time,
      name: `all senses, object ${number(fields, "objectId")}`,
      predicted: `at most ${number(fields, "threshold").toFixed(1)} bits`,
      felt: `${bits.toFixed(1)} bits`,
      surprising: truth(fields, "alarm"),
      bits,
      reaction: alarmed.map((sense) => `${text(sense, "sense")} ${number(sense, "bits").toFixed(1)} bits`).join(", "),
    });
  },
};
