/** The graph's own messages of what is seen and predicted: objects, models, camera images. */

import { bytes, child, children, has, number, numbers, optionalNumber, text } from "../protobuf/fields.js";
import { setPicture } from "./foxglove.js";
import { meshOf, planePose, pointsOf, poseOf, turned } from "./geometry.js";
import type { Handlers } from "./handler.js";
import { pixels } from "./pictures.js";
import { entity, header } from "./raw_header.js";
import { kNoPose, kOrigins, type Color, type Mesh, type Vector } from "./types.js";

/** SurfaceOrigin of objects.proto: seen, predicted, assumed, touched -> places in kOrigins. */
const kOriginOf = [0, 1, 3, 2];
const kTableColor: Color = [0.62, 0.6, 0.57, 1];
const kTableSize = 1.2; // m, of the table that is drawn; how far it goes is not said
const kCamera = "camera";

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
      store.setEntity(
        topic,
        weight === undefined ? shown : { ...shown, metadata: new Map([["weight", weight.toFixed(3)]]) },
      );
    });
  },

  "prehend.msgs.StereoPair": (store, { topic, fields }) => {
    const [width, height, channels] = [number(fields, "width"), number(fields, "height"), number(fields, "channels")];
    const encoding = channels === 1 ? "mono8" : "rgb8";
    const data = bytes(fields, "data");
    const half = width * height * channels;
    if (data.length !== 2 * half)
      throw new Error(`a stereo pair of ${width} x ${height} pixels has ${data.length} bytes`);
    setPicture(store, `${topic} left`, pixels(width, height, 0, encoding, data.subarray(0, half)));
    setPicture(store, `${topic} right`, pixels(width, height, 0, encoding, data.subarray(half)));
  },

  "prehend.msgs.Image": (store, { topic, fields }) => {
    const encoding = number(fields, "channels") === 1 ? "mono8" : "rgb8";
    setPicture(
      store,
      topic,
      pixels(number(fields, "width"), number(fields, "height"), 0, encoding, bytes(fields, "data")),
    );
  },

  "prehend.msgs.DepthImage": (store, { topic, fields }) => {
    const [width, height] = [number(fields, "width"), number(fields, "height")];
    setPicture(store, topic, pixels(width, height, 0, "mono16", bytes(fields, "data")));
  },
};
