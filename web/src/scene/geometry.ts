/** Geometry out of messages, of both families: `foxglove.*` and `prehend.msgs.*`. */

import { bytes, child, has, number, truth, type Fields } from "../protobuf/fields.js";
import type { Mesh, Pose, Rotation, Vector } from "./types.js";

const kMostPoints = 5_000_000;

export function vectorOf(from: Fields): Vector {
  return [number(from, "x"), number(from, "y"), number(from, "z")];
}

/** A unit quaternion; one that is not set, or of no length, turns nothing. */
export function rotationOf(from: Fields): Rotation {
  const q: Rotation = [number(from, "x"), number(from, "y"), number(from, "z"), number(from, "w")];
  const length = Math.hypot(...q);
  if (!(length > 1e-9) || !Number.isFinite(length)) return [0, 0, 0, 1];
  return [q[0] / length, q[1] / length, q[2] / length, q[3] / length];
}

export function poseOf(from: Fields): Pose {
  return { position: vectorOf(child(from, "position")), rotation: rotationOf(child(from, "orientation")) };
}

/** The rotation that takes x to `direction` [unit]; any that does. */
export function rotationToX(direction: Vector): Rotation {
  const [x, y, z] = direction;
  if (x < -0.999999) return [0, 0, 1, 0]; // half a turn about z
  const w = 1 + x; // of the cross product (0, -z, y) and the dot product x
  const length = Math.hypot(w, z, y);
  return length > 0 ? [0, -z / length, y / length, w / length] : [0, 0, 0, 1];
}

/** `v` turned by the rotation. */
export function turned(rotation: Rotation, v: Vector): Vector {
  const [x, y, z, w] = rotation;
  const tx = 2 * (y * v[2] - z * v[1]);
  const ty = 2 * (z * v[0] - x * v[2]);
  const tz = 2 * (x * v[1] - y * v[0]);
  return [v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx];
}

/** Float32 numbers of little-endian bytes at any place. */
export function floats(data: Uint8Array, at: number, count: number): Float32Array {
  if (at < 0 || at + 4 * count > data.length) throw new Error(`${count} numbers at byte ${at} of ${data.length}`);
  return new Float32Array(data.slice(at, at + 4 * count).buffer);
}

/** prehend.msgs.TriangleMesh. Throws an Error in words where its counts contradict its bytes. */
export function meshOf(from: Fields): Mesh {
  const vertices = number(from, "vertexCount");
  const triangles = number(from, "triangleCount");
  const data = bytes(from, "data");
  if (data.length !== 12 * (vertices + triangles)) {
    throw new Error(`a mesh of ${vertices} vertices and ${triangles} triangles has ${data.length} bytes`);
  }
  const indices = new Uint32Array(data.slice(12 * vertices).buffer);
  if (indices.some((index) => index >= vertices)) throw new Error("a triangle of a mesh names no vertex of it");
  return { positions: floats(data, 0, 3 * vertices), indices, colors: null };
}

export interface Points {
  count: number;
  positions: Float32Array;
  colors: Uint8Array | null;
}

/** prehend.msgs.PointCloud. Throws an Error in words where its numbers contradict its bytes. */
export function pointsOf(from: Fields): Points {
  const count = number(from, "count");
  const stride = number(from, "stride");
  const data = aligned(bytes(from, "data"));
  const coloured = truth(from, "hasColor");
  const least = 12 + (coloured ? 4 : 0) + (truth(from, "hasNormal") ? 12 : 0);
  if (count > kMostPoints || (count > 0 && stride < least) || data.length !== count * stride) {
    throw new Error(`a cloud of ${count} points of ${stride} bytes has ${data.length} bytes`);
  }
  return {
    count,
    positions: column(data, count, stride, 0),
    colors: coloured ? colorColumn(data, count, stride, [12, 13, 14]) : null,
  };
}

let scratch = new Uint8Array();

/**
 * Bytes at a multiple of 4 of their buffer, so that views of wider numbers can lie on them. Where they are not, a
 * copy that holds until the next call: clouds come many times a second, and new memory for each costs more than
 * copying.
 */
export function aligned(data: Uint8Array): Uint8Array {
  if (data.byteOffset % 4 === 0) return data;
  if (scratch.length < data.length) scratch = new Uint8Array(data.length);
  scratch.set(data);
  return scratch.subarray(0, data.length);
}

/** `old` where it has that many elements, else a new array; so a cloud takes over the memory of the one before it. */
function reused<Kind extends Float32Array | Uint8Array | Uint16Array>(
  old: Kind | null | undefined,
  length: number,
  make: (length: number) => Kind,
): Kind {
  return old?.length === length ? old : make(length);
}

/** x, y, z of records of `stride` bytes. */
export function column(
  data: Uint8Array,
  count: number,
  stride: number,
  offset: number,
  old?: Float32Array | null,
): Float32Array {
  const result = reused(old, 3 * count, (length) => new Float32Array(length));
  if (stride % 4 === 0 && offset % 4 === 0 && data.byteOffset % 4 === 0) {
    const all = new Float32Array(data.buffer, data.byteOffset, data.byteLength >> 2);
    const step = stride >> 2;
    for (let i = 0, from = offset >> 2, to = 0; i < count; i++, from += step, to += 3) {
      result[to] = all[from]!;
      result[to + 1] = all[from + 1]!;
      result[to + 2] = all[from + 2]!;
    }
    return result;
  }
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  for (let i = 0, from = offset, to = 0; i < count; i++, from += stride) {
    result[to++] = view.getFloat32(from, true);
    result[to++] = view.getFloat32(from + 4, true);
    result[to++] = view.getFloat32(from + 8, true);
  }
  return result;
}

/** Opaque rgba of the three bytes at these offsets of each record. */
export function colorColumn(
  data: Uint8Array,
  count: number,
  stride: number,
  offsets: number[],
  old?: Uint8Array | null,
): Uint8Array {
  const result = reused(old, 4 * count, (length) => new Uint8Array(length));
  const [red = 0, green = 0, blue = 0] = offsets;
  if (
    stride % 4 === 0 &&
    red % 4 === 0 &&
    green === red + 1 &&
    blue === red + 2 &&
    data.byteOffset % 4 === 0 &&
    red + 4 <= stride
  ) {
    const all = new Uint32Array(data.buffer, data.byteOffset, data.byteLength >> 2);
    const words = new Uint32Array(result.buffer, result.byteOffset, count);
    const step = stride >> 2;
    for (let i = 0, from = red >> 2; i < count; i++, from += step) words[i] = all[from]! | 0xff000000;
    return result;
  }
  for (let i = 0, from = 0, to = 0; i < count; i++, from += stride, to += 4) {
    result[to] = data[from + red]!;
    result[to + 1] = data[from + green]!;
    result[to + 2] = data[from + blue]!;
    result[to + 3] = 255;
  }
  return result;
}

/** A number of 16 bits of each record. */
export function shortColumn(
  data: Uint8Array,
  count: number,
  stride: number,
  offset: number,
  old?: Uint16Array | null,
): Uint16Array {
  const result = reused(old, count, (length) => new Uint16Array(length));
  if (stride % 2 === 0 && offset % 2 === 0 && data.byteOffset % 2 === 0) {
    const all = new Uint16Array(data.buffer, data.byteOffset, data.byteLength >> 1);
    const step = stride >> 1;
    for (let i = 0, from = offset >> 1; i < count; i++, from += step) result[i] = all[from]!;
    return result;
  }
  for (let i = 0, from = offset; i < count; i++, from += stride) result[i] = data[from]! | (data[from + 1]! << 8);
  return result;
}

/** A point of a plane and the rotation that takes z to its normal; null: there is no plane. */
export function planePose(from: Fields): Pose | null {
  if (!has(from, "normal")) return null;
  const normal = vectorOf(child(from, "normal"));
  const length = Math.hypot(...normal);
  if (!(length > 1e-6)) return null;
  const unit: Vector = [normal[0] / length, normal[1] / length, normal[2] / length];
  const offset = number(from, "offset");
  const w = 1 + unit[2];
  const q: Rotation = w < 1e-6 ? [1, 0, 0, 0] : [-unit[1], unit[0], 0, w];
  const size = Math.hypot(...q);
  return {
    position: [unit[0] * offset, unit[1] * offset, unit[2] * offset],
    rotation: [q[0] / size, q[1] / size, q[2] / size, q[3] / size],
  };
}
