/** The graph's own messages of what is seen and planned: objects, models, plans, camera images. */

import {
  bytes, child, children, has, integer64, number, numbers, optionalNumber, text, type Fields,
} from "../protobuf/fields.js";
import { meshOf, planePose, pointsOf, poseOf, rotationToX, turned, vectorOf } from "./geometry.js";
import type { Handlers } from "./handler.js";
import { pixels } from "./pictures.js";
import { setPicture } from "./foxglove.js";
import { kGraspsTopic, kRawPlansTopic } from "./store.js";
import { tactileImage } from "./raw_signals.js";
import { kNoPose, kOrigins, type Color, type Entity, type GraspInfo, type Mesh, type PadImage, type Plan, type Pose,
  type Primitive, type Vector } from "./types.js";

/** SurfaceOrigin of objects.proto: seen, predicted, assumed, touched -> places in kOrigins. */
const kOriginOf = [0, 1, 3, 2];
const kTableColor: Color = [0.62, 0.6, 0.57, 1];
const kTableSize = 1.2; // m, of the table that is drawn; how far it goes is not said
const kCamera = "camera";

function header(fields: Fields): { stamp: bigint; frame: string } {
  const from = child(fields, "header");
  return { stamp: integer64(from, "stamp"), frame: text(from, "frameId") || "world" };
}

function entity(id: string, primitives: Primitive[]): Entity {
  return { id, frame: "world", primitives, metadata: new Map() };
}

function colored(mesh: Mesh, origin: Uint8Array): Mesh {
  const vertices = mesh.positions.length / 3;
  if (origin.length !== vertices) return mesh;
  const colors = new Uint8Array(4 * vertices);
  for (let i = 0; i < vertices; i++) {
    const { color } = kOrigins[kOriginOf[origin[i]!] ?? 3]!;
    for (let c = 0; c < 4; c++) colors[4 * i + c] = Math.round(255 * color[c]!);
  }
  return { ...mesh, colors };
}

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
    result.push({ kind: "sphere", pose: { position: contact, rotation: [0, 0, 0, 1] }, size: [0.01, 0.01, 0.01], color });
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

export const kShapeHandlers: Handlers = {
  "prehend.msgs.CameraInfo": (store, { fields }) => {
    if (has(fields, "XWC")) {
      store.frames.set(kCamera, { parent: "world", pose: poseOf(child(fields, "XWC")) });
      store.touch("frames");
    }
  },

  "prehend.msgs.ObjectHypotheses": (store, { topic, fields }) => {
    const { stamp, frame } = header(fields);
    if (!store.beginView(stamp)) return;
    const camera = child(fields, "camera");
    if (has(camera, "XWC")) store.frames.set(kCamera, { parent: frame, pose: poseOf(child(camera, "XWC")) });
    store.touch("frames");
    const table = planePose(child(fields, "table"));
    if (table) {
      const down = turned(table.rotation, [0, 0, -0.005]);
      const position: Vector = [table.position[0] + down[0], table.position[1] + down[1], table.position[2] + down[2]];
      const size: Vector = [kTableSize, kTableSize, 0.01];
      const pose = { position, rotation: table.rotation };
      store.setEntity(`raw ${topic}`, entity("table", [{ kind: "cube", pose, size, color: kTableColor }]));
    }
    const seen = children(fields, "objects").map((object) => ({
      id: number(object, "id"),
      points: pointsOf(child(object, "cloud")),
    }));
    const count = seen.reduce((sum, { points }) => sum + points.count, 0);
    const cloud = {
      frame,
      count,
      positions: new Float32Array(3 * count),
      colors: seen.every(({ points }) => points.colors) ? new Uint8Array(4 * count) : null,
      objects: new Uint16Array(count),
    };
    let at = 0;
    for (const { id, points } of seen) {
      cloud.positions.set(points.positions, 3 * at);
      if (points.colors) cloud.colors?.set(points.colors, 4 * at);
      cloud.objects.fill(id, at, at + points.count);
      at += points.count;
      if (!store.objects.has(id)) store.objects.set(id, { id, problem: "", details: [] });
    }
    store.cloud = cloud;
    store.touch("cloud");
    store.touch("objects");
  },

  "prehend.msgs.ObjectModel": (store, { fields }) => {
    if (!store.beginView(header(fields).stamp)) return;
    const id = number(fields, "id");
    const topic = "raw models";
    const details: { name: string; value: string }[] = [];
    const interval = (name: string, unit: string): void => {
      const from = child(fields, name);
      const [low, high] = [optionalNumber(from, "low"), optionalNumber(from, "high")];
      if (low === undefined && high === undefined) return;
      details.push({ name, value: `${low?.toFixed(3) ?? "…"} – ${high?.toFixed(3) ?? "…"}${unit}` });
    };
    interval("mass", " kg");
    interval("friction", "");
    if (text(fields, "substitute")) details.push({ name: "mesh", value: text(fields, "substitute") });
    const defects = text(fields, "meshDefects");
    if (defects !== "" && defects !== "watertight") details.push({ name: "defects", value: defects });
    const [method, known] = [text(fields, "method"), text(child(fields, "known"), "name")];
    store.objects.set(id, {
      id,
      problem: text(fields, "problem"),
      confidence: number(fields, "confidence"),
      volume: number(fields, "volume"),
      guessedArea: number(fields, "guessedArea"),
      ...(method && { method }),
      ...(known && { known }),
      details,
    });
    store.touch("objects");
    for (const other of [...(store.entities.get(topic)?.keys() ?? [])]) {
      if (other === `object/${id}` || other.startsWith(`object/${id}/`)) store.deleteEntity(topic, other);
    }
    if (!has(fields, "mesh")) return;
    const mesh = colored(meshOf(child(fields, "mesh")), bytes(fields, "vertexOrigin"));
    const color: Color = [0.62, 0.62, 0.62, 1];
    store.setEntity(topic, entity(`object/${id}`, [{ kind: "mesh", pose: kNoPose, mesh, color }]));
    const weights = numbers(fields, "shapeWeight");
    children(fields, "alternatives").forEach((alternative, i) => {
      const shown = entity(`object/${id}/alternative/${i}`, [
        { kind: "mesh", pose: kNoPose, mesh: meshOf(alternative), color: [0.62, 0.62, 0.62, 0.25] },
      ]);
      const weight = weights[i + 1];
      store.setEntity(topic, weight === undefined ? shown : { ...shown, metadata: new Map([["weight", weight.toFixed(3)]]) });
    });
  },

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

  "prehend.msgs.StereoPair": (store, { topic, fields }) => {
    const [width, height, channels] = [number(fields, "width"), number(fields, "height"), number(fields, "channels")];
    const encoding = channels === 1 ? "mono8" : "rgb8";
    const data = bytes(fields, "data");
    const half = width * height * channels;
    if (data.length !== 2 * half) throw new Error(`a stereo pair of ${width} x ${height} pixels has ${data.length} bytes`);
    setPicture(store, `${topic} left`, pixels(width, height, 0, encoding, data.subarray(0, half)));
    setPicture(store, `${topic} right`, pixels(width, height, 0, encoding, data.subarray(half)));
  },

  "prehend.msgs.Image": (store, { topic, fields }) => {
    const encoding = number(fields, "channels") === 1 ? "mono8" : "rgb8";
    setPicture(store, topic, pixels(number(fields, "width"), number(fields, "height"), 0, encoding, bytes(fields, "data")));
  },

  "prehend.msgs.DepthImage": (store, { topic, fields }) => {
    const [width, height] = [number(fields, "width"), number(fields, "height")];
    setPicture(store, topic, pixels(width, height, 0, "mono16", bytes(fields, "data")));
  },
};
