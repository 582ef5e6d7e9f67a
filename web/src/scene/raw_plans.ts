/** The graph's own plans: grasps, best first, how they are drawn, and the ledger of what was tried. */

import { child, children, number, optionalNumber, text, type Fields } from "../protobuf/fields.js";
import { poseOf, rotationToX, turned, vectorOf } from "./geometry.js";
import type { Handlers } from "./handler.js";
import { entity, header } from "./raw_header.js";
import { tactileImage } from "./raw_signals.js";
import { kGraspsTopic, kRawPlansTopic } from "./store.js";
import type { Color, GraspInfo, PadImage, Plan, Pose, Primitive, Vector } from "./types.js";

function jaw(pose: Pose, at: Vector, size: Vector, color: Color): Primitive {
  const offset = turned(pose.rotation, at);
  const position: Vector = [pose.position[0] + offset[0], pose.position[1] + offset[1], pose.position[2] + offset[2]];
  return { kind: "cube", pose: { position, rotation: pose.rotation }, size, color };
}

/** The approach as an arrow; fingertips at the contacts, or the jaws of a parallel gripper open as it comes. */
function graspPrimitives(grasp: Fields, color: Color): Primitive[] {
  const result: Primitive[] = [];
  const pose = poseOf(child(grasp, "XWG"));
  const direction = vectorOf(child(grasp, "approachDirection"));
  const contacts = children(grasp, "contacts").map(vectorOf);
  const length = Math.max(0.04, Math.min(0.15, number(grasp, "pregraspDistance", 0.08)));
  const size = Math.hypot(...direction);
  if (size > 0.5) {
    const unit: Vector = [direction[0] / size, direction[1] / size, direction[2] / size];
    const head = contacts.length > 0 ? mean(contacts) : pose.position;
    const position: Vector = [head[0] - unit[0] * length, head[1] - unit[1] * length, head[2] - unit[2] * length];
    result.push({
      kind: "arrow",
      pose: { position, rotation: rotationToX(unit) },
      shaftLength: 0.7 * length,
      shaftDiameter: 0.004,
      headLength: 0.3 * length,
      headDiameter: 0.012,
      color,
    });
  }
  for (const contact of contacts) {
    result.push({
      kind: "sphere",
      pose: { position: contact, rotation: [0, 0, 0, 1] },
      size: [0.01, 0.01, 0.01],
      color,
    });
  }
  const opening = number(grasp, "pregraspOpening");
  if (opening > 0) {
    // Pads of a parallel gripper close along y of its frame.
    for (const side of [-1, 1]) {
      result.push(jaw(pose, [0, (side * (opening + 0.008)) / 2, -0.015], [0.02, 0.006, 0.045], color));
    }
    result.push(jaw(pose, [0, 0, -0.042], [0.02, opening + 0.014, 0.012], color));
  }
  return result;
}

function mean(points: Vector[]): Vector {
  const sum: Vector = [0, 0, 0];
  for (const point of points) for (let c = 0; c < 3; c++) sum[c]! += point[c]! / points.length;
  return sum;
}

function predictedPads(grasp: Fields): Map<string, PadImage> {
  const result = new Map<string, PadImage>();
  for (const pad of children(child(grasp, "predicted"), "pads")) {
    const image = child(pad, "image");
    const name = text(child(image, "header"), "frameId");
    const read = tactileImage(image);
    if (name !== "" && read) result.set(name, read);
  }
  return result;
}

/** Choice.Act of grasp.proto. */
const kGraspAct = 1;

export function planOf(fields: Fields): Plan {
  const object = number(fields, "id");
  const chances = new Map<number, number>();
  for (const choice of children(fields, "choices")) {
    if (number(choice, "act") === kGraspAct) chances.set(number(choice, "grasp"), number(choice, "success"));
  }
  const grasps = children(fields, "grasps").map((grasp, rank): GraspInfo => {
    const [success, robustness] = [chances.get(rank), optionalNumber(grasp, "robustness")];
    return {
      object,
      rank,
      quality: number(grasp, "quality"),
      guessedContact: number(grasp, "guessedContact"),
      width: number(grasp, "pregraspOpening"),
      ...(success !== undefined && { success }),
      ...(robustness !== undefined && { robustness }),
      generator: text(grasp, "generator"),
      remark: text(grasp, "remark"),
      contacts: children(grasp, "contacts").map(vectorOf),
      predicted: predictedPads(grasp),
    };
  });
  return {
    object,
    stamp: header(fields).stamp,
    outcome: (["failed", "ungraspable", "graspable"] as const)[number(fields, "outcome")] ?? "failed",
    problem: text(fields, "problem"),
    candidates: number(fields, "candidates"),
    grasps,
    rejections: children(fields, "rejections")
      .map((rejection) => ({
        reason: text(rejection, "reason"),
        count: number(rejection, "count"),
        generator: text(rejection, "generator"),
        nearestMiss: text(rejection, "nearestMiss"),
      }))
      .sort((a, b) => b.count - a.count),
    remedies: children(fields, "remedies").map((remedy) => text(remedy, "text")),
    choices: children(fields, "choices").map((choice) => text(choice, "text")),
  };
}

const kGraspColor: Color = [0.1, 0.55, 0.62, 1];

export const kPlanHandlers: Handlers = {
  "prehend.msgs.GraspPlan": (store, { fields }) => {
    const plan = planOf(fields);
    if (!store.beginView(plan.stamp)) return;
    store.plans.set(plan.object, plan);
    if (!store.objects.has(plan.object)) store.objects.set(plan.object, { id: plan.object, problem: "", details: [] });
    store.touch("objects");
    if (store.entities.has(kGraspsTopic)) return; // whoever converts them draws them
    const topic = kRawPlansTopic;
    for (const other of [...(store.entities.get(topic)?.keys() ?? [])]) {
      if (other.startsWith(`grasp/${plan.object}/`)) store.deleteEntity(topic, other);
    }
    children(fields, "grasps")
      .slice(0, 100)
      .forEach((grasp, rank) => {
        store.setEntity(topic, entity(`grasp/${plan.object}/${rank}`, graspPrimitives(grasp, kGraspColor)));
      });
  },
};
