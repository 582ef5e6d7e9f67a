/** The well-known types `foxglove.*`: scene, frames, clouds, images, logs. */

import { bytes, child, children, has, integer64, number, text, type Fields } from "../protobuf/fields.js";
import type { TriangleList } from "../protobuf/triangle_lists.js";
import { seconds } from "../time.js";
import { kGraspsTopic, kObjectsTopic, kRawPlansTopic } from "./store.js";
import { aligned, colorColumn, column, poseOf, rotationOf, shortColumn, vectorOf } from "./geometry.js";
import type { Handlers } from "./handler.js";
import { objectFromEntity, graspFromEntity } from "./entity_info.js";
import { pixels } from "./pictures.js";
import type { Color, Entity, Level, Mesh, Picture, Primitive } from "./types.js";

const kMostPoints = 5_000_000;

function stampOf(from: Fields): number {
  const stamp = child(from, "timestamp");
  return seconds(integer64(stamp, "seconds") * 1_000_000_000n + BigInt(Math.trunc(number(stamp, "nanos"))));
}

function colorOf(from: Fields): Color {
  return [number(from, "r"), number(from, "g"), number(from, "b"), number(from, "a")];
}

function pointsOf(list: Fields[]): Float32Array {
  const result = new Float32Array(3 * list.length);
  for (let i = 0; i < list.length; i++) {
    const point = list[i]!;
    result[3 * i] = number(point, "x");
    result[3 * i + 1] = number(point, "y");
    result[3 * i + 2] = number(point, "z");
  }
  return result;
}

function triangles({ positions, colors, indices }: TriangleList): Mesh {
  const vertices = positions.length / 3;
  if (indices.some((index) => index >= vertices))
    throw new Error("a triangle names a vertex that its mesh does not have");
  if ((indices.length || vertices) % 3 !== 0)
    throw new Error("the vertices of a triangle list are no multiple of three");
  return {
    positions,
    indices: indices.length > 0 ? indices : null,
    colors: colors.length === 4 * vertices && vertices > 0 ? colors : null,
  };
}

function primitivesOf(entity: Fields, lists: TriangleList[]): Primitive[] {
  const result: Primitive[] = [];
  const each = (name: string, make: (from: Fields) => Primitive): void => {
    for (const from of children(entity, name)) result.push(make(from));
  };
  const common = (from: Fields) => ({ pose: poseOf(child(from, "pose")), color: colorOf(child(from, "color")) });
  const size = (from: Fields) => vectorOf(child(from, "size"));
  each("arrows", (from) => ({
    kind: "arrow",
    ...common(from),
    shaftLength: number(from, "shaftLength"),
    shaftDiameter: number(from, "shaftDiameter"),
    headLength: number(from, "headLength"),
    headDiameter: number(from, "headDiameter"),
  }));
  each("cubes", (from) => ({ kind: "cube", ...common(from), size: size(from) }));
  each("spheres", (from) => ({ kind: "sphere", ...common(from), size: size(from) }));
  each("cylinders", (from) => ({
    kind: "cylinder",
    ...common(from),
    size: size(from),
    bottomScale: number(from, "bottomScale", 1),
    topScale: number(from, "topScale", 1),
  }));
  each("lines", (from) => ({
    kind: "line",
    ...common(from),
    shape: (["strip", "loop", "list"] as const)[number(from, "type")] ?? "strip",
    points: pointsOf(children(from, "points")),
  }));
  children(entity, "triangles").forEach((from, i) => {
    const list = lists[i];
    if (list) result.push({ kind: "mesh", ...common(from), mesh: triangles(list) });
  });
  each("texts", (from) => ({
    kind: "text",
    ...common(from),
    text: text(from, "text"),
    size: number(from, "fontSize"),
    isScaleInvariant: from["scaleInvariant"] === true,
  }));
  each("models", (from) => ({
    kind: "model",
    pose: poseOf(child(from, "pose")),
    scale: has(from, "scale") ? vectorOf(child(from, "scale")) : [1, 1, 1],
    color: from["overrideColor"] === true ? colorOf(child(from, "color")) : null,
    mediaType: text(from, "mediaType"),
    data: bytes(from, "data"),
  }));
  return result;
}

function entityOf(from: Fields, lists: TriangleList[]): Entity {
  return {
    id: text(from, "id"),
    frame: text(from, "frameId"),
    primitives: primitivesOf(from, lists),
    metadata: new Map(children(from, "metadata").map((pair) => [text(pair, "key"), text(pair, "value")])),
  };
}

const kLevels: Level[] = ["info", "debug", "info", "warning", "error", "error"];

/** Places of the packed columns by name; those of another type than expected are not there. */
function packed(fields: Fields[], stride: number): Map<string, number> {
  const kTypes: Readonly<Record<string, [type: number, size: number]>> = {
    x: [7, 4],
    y: [7, 4],
    z: [7, 4],
    red: [1, 1],
    green: [1, 1],
    blue: [1, 1],
    object: [3, 2],
  };
  const result = new Map<string, number>();
  for (const field of fields) {
    const name = text(field, "name");
    const offset = number(field, "offset");
    const [type, size] = kTypes[name] ?? [-1, 0];
    if (number(field, "type") === type && offset + size <= stride) result.set(name, offset);
  }
  return result;
}

export const kFoxgloveHandlers: Handlers = {
  "foxglove.FrameTransforms": (store, { fields }) => {
    for (const transform of children(fields, "transforms")) {
      const name = text(transform, "childFrameId");
      if (name === "" || (store.frames.size >= 5000 && !store.frames.has(name))) continue;
      store.frames.set(name, {
        parent: text(transform, "parentFrameId"),
        pose: {
          position: vectorOf(child(transform, "translation")),
          rotation: rotationOf(child(transform, "rotation")),
        },
      });
    }
    store.touch("frames");
  },

  "foxglove.SceneUpdate": (store, { topic, fields, lists = [] }) => {
    for (const deletion of children(fields, "deletions")) {
      const id = number(deletion, "type") === 1 ? undefined : text(deletion, "id");
      store.deleteEntity(topic, id);
      if (topic === kObjectsTopic) {
        if (id === undefined) store.objects.clear();
        else store.objects.delete(Number(id.split("/")[1]));
        store.touch("objects");
      }
    }
    if (topic === kGraspsTopic) store.deleteEntity(kRawPlansTopic);
    let problem: unknown;
    for (const [i, given] of children(fields, "entities").entries()) {
      try {
        const entity = entityOf(given, lists[i] ?? []);
        store.setEntity(topic, entity);
        objectFromEntity(store, entity);
        graspFromEntity(store, entity);
      } catch (error) {
        problem = error; // the others are shown
      }
    }
    if (problem) throw problem;
  },

  "foxglove.PointCloud": (store, { fields }) => {
    const stride = number(fields, "pointStride");
    const data = aligned(bytes(fields, "data"));
    const count = stride > 0 ? data.length / stride : 0;
    if (!Number.isInteger(count) || count > kMostPoints)
      throw new Error(`a cloud of ${data.length} bytes has points of ${stride}`);
    const at = packed(children(fields, "fields"), stride);
    const x = at.get("x");
    if (count > 0 && (x === undefined || at.get("y") !== x + 4 || at.get("z") !== x + 8)) {
      throw new Error("the points of a cloud have no x, y, z of 32 bits in a row");
    }
    const [red, green, blue] = [at.get("red"), at.get("green"), at.get("blue")];
    const coloured = red !== undefined && green !== undefined && blue !== undefined;
    const object = at.get("object");
    const old = store.cloud;
    store.cloud = {
      frame: text(fields, "frameId"),
      count,
      positions: column(data, count, stride, x ?? 0, old?.positions),
      colors: coloured ? colorColumn(data, count, stride, [red, green, blue], old?.colors) : null,
      objects: object === undefined ? null : shortColumn(data, count, stride, object, old?.objects),
    };
    store.touch("cloud");
  },

  "foxglove.RawImage": (store, { topic, fields }) => {
    const [width, height] = [number(fields, "width"), number(fields, "height")];
    if (topic.startsWith("/viewer/pad/")) {
      setPad(store, topic.slice("/viewer/pad/".length), width, height, bytes(fields, "data"));
      return;
    }
    setPicture(
      store,
      topic,
      pixels(width, height, number(fields, "step"), text(fields, "encoding"), bytes(fields, "data")),
    );
  },

  "foxglove.CompressedImage": (store, { topic, fields }) => {
    const format = text(fields, "format");
    if (!/^(jpeg|png|webp|avif)$/.test(format)) throw new Error(`images compressed as "${format}" are not shown`);
    setPicture(store, topic, {
      kind: "compressed",
      blob: new Blob([bytes(fields, "data").slice()], { type: `image/${format}` }),
    });
  },

  "foxglove.Log": (store, { fields }) => {
    store.addLog({
      time: stampOf(fields),
      level: kLevels[number(fields, "level")] ?? "info",
      node: text(fields, "name"),
      text: text(fields, "message"),
    });
  },
};

/** Adds a picture; at most sixteen are kept, however many topics there are. */
export function setPicture(store: Parameters<Handlers[string]>[0], topic: string, picture: Picture): void {
  if (store.pictures.size >= 16 && !store.pictures.has(topic)) return;
  store.pictures.set(topic, picture);
  store.touch("pictures");
}

function setPad(
  store: Parameters<Handlers[string]>[0],
  name: string,
  columns: number,
  rows: number,
  data: Uint8Array,
): void {
  const cells = rows * columns;
  if (cells === 0 || data.length < 4 * cells)
    throw new Error(`pad ${name} of ${rows} x ${columns} cells has ${data.length} bytes`);
  const forces = new Float32Array(data.slice(0, 4 * cells).buffer);
  store.pads.set(name, { rows, columns, forces, sum: forces.reduce((sum, force) => sum + force, 0) });
  store.touch("pads");
}
