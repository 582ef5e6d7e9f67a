/** What the metadata of entities `object/ID` and `grasp/OBJECT/RANK` says of them, for lists beside the view. */

import type { Store } from "./store.js";
import type { Entity, GraspInfo } from "./types.js";

/** The number that a text begins with, as "0.82" or "1.2e-4 m^3"; undefined: it begins with none. */
function numberIn(text: string | undefined): number | undefined {
  const value = text === undefined ? Number.NaN : Number.parseFloat(text);
  return Number.isFinite(value) ? value : undefined;
}

const kShownApart = new Set(["confidence", "volume", "problem", "method", "known", "guessed_area", "object"]);

export function objectFromEntity(store: Store, entity: Entity): void {
  const match = /^object\/(\d+)$/.exec(entity.id);
  if (!match) return;
  const id = Number(match[1]);
  const { metadata } = entity;
  const [confidence, volume, guessedArea] = ["confidence", "volume", "guessed_area"].map((key) =>
    numberIn(metadata.get(key)),
  );
  const [method, known] = [metadata.get("method"), metadata.get("known")];
  store.objects.set(id, {
    id,
    problem: metadata.get("problem") ?? "",
    ...(confidence !== undefined && { confidence }),
    ...(volume !== undefined && { volume }),
    ...(guessedArea !== undefined && { guessedArea }),
    ...(method && { method }),
    ...(known && { known }),
    details: [...metadata]
      .filter(([name, value]) => !kShownApart.has(name) && value !== "" && !(name === "watertight" && value === "true"))
      .map(([name, value]) => ({ name: name.replaceAll("_", " "), value })),
  });
  store.touch("objects");
}

/** A server that does not offer the plans themselves still has its grasps listed. */
export function graspFromEntity(store: Store, entity: Entity): void {
  const match = /^grasp\/(\d+)\/(\d+)$/.exec(entity.id);
  if (!match) return;
  const [object, rank] = [Number(match[1]), Number(match[2])];
  const { metadata } = entity;
  const plan = store.plans.get(object) ?? {
    object,
    stamp: -1n, // of entities alone; a plan replaces it
    outcome: "graspable" as const,
    problem: "",
    candidates: 0,
    grasps: [],
    rejections: [],
    remedies: [],
    choices: [],
  };
  if (plan.stamp !== -1n) return;
  const [quality, success, width] = [
    numberIn(metadata.get("quality")),
    numberIn(metadata.get("success probability") ?? metadata.get("success_probability") ?? metadata.get("success")),
    numberIn(metadata.get("width")),
  ];
  const grasp: GraspInfo = {
    object,
    rank,
    ...(quality !== undefined && { quality }),
    ...(success !== undefined && { success }),
    ...(width !== undefined && { width }),
    generator: metadata.get("generator") ?? "",
    remark: metadata.get("problem") ?? metadata.get("remark") ?? "",
    contacts: [],
    predicted: new Map(),
  };
  plan.grasps = [...plan.grasps.filter((other) => other.rank !== rank), grasp].sort((a, b) => a.rank - b.rank);
  store.plans.set(object, plan);
  store.touch("objects");
}
