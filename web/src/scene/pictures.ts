/** Images of the wire as pixels that a canvas takes. */

import type { Picture } from "./types.js";
import { kRamp } from "../view/ramp.js";

const kMostPixels = 64e6;

/** Bytes a pixel and how they become red, green, blue. */
const kEncodings: Readonly<Record<string, { size: number; order: [number, number, number] }>> = {
  rgb8: { size: 3, order: [0, 1, 2] },
  bgr8: { size: 3, order: [2, 1, 0] },
  rgba8: { size: 4, order: [0, 1, 2] },
  bgra8: { size: 4, order: [2, 1, 0] },
  mono8: { size: 1, order: [0, 0, 0] },
  "8UC1": { size: 1, order: [0, 0, 0] },
};

/** Rows of `step` bytes from the top. Throws an Error in words where the numbers contradict the bytes. */
export function pixels(width: number, height: number, step: number, encoding: string, data: Uint8Array): Picture {
  if (width * height > kMostPixels) throw new Error(`an image of ${width} x ${height} pixels is too large`);
  if (encoding === "32FC1" || encoding === "mono16" || encoding === "16UC1") {
    return scalarPixels(width, height, step, encoding === "32FC1" ? 4 : 2, data);
  }
  const known = kEncodings[encoding];
  if (!known) throw new Error(`images encoded as "${encoding}" are not shown`);
  const row = step || width * known.size;
  if (row < width * known.size || data.length < row * height) {
    throw new Error(`an image of ${width} x ${height} pixels (${encoding}) has ${data.length} bytes`);
  }
  const rgba = new Uint8ClampedArray(4 * width * height);
  const [red, green, blue] = known.order;
  let to = 0;
  for (let y = 0; y < height; y++) {
    for (let x = 0, from = y * row; x < width; x++, from += known.size, to += 4) {
      rgba[to] = data[from + red]!;
      rgba[to + 1] = data[from + green]!;
      rgba[to + 2] = data[from + blue]!;
      rgba[to + 3] = 255;
    }
  }
  return { kind: "pixels", width, height, rgba };
}

/** Depths: coloured from the nearest to the farthest, transparent where it is 0 or no number. */
function scalarPixels(width: number, height: number, step: number, size: 2 | 4, data: Uint8Array): Picture {
  const row = step || width * size;
  if (row < width * size || data.length < row * height) {
    throw new Error(`a depth image of ${width} x ${height} pixels has ${data.length} bytes`);
  }
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const values = new Float32Array(width * height);
  let low = Infinity;
  let high = -Infinity;
  for (let y = 0, i = 0; y < height; y++) {
    for (let x = 0; x < width; x++, i++) {
      const at = y * row + x * size;
      const value = size === 4 ? view.getFloat32(at, true) : view.getUint16(at, true);
      values[i] = value;
      if (value > 0 && value < Infinity) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
  }
  const rgba = new Uint8ClampedArray(4 * width * height);
  for (let i = 0; i < values.length; i++) {
    const value = values[i]!;
    if (!(value > 0 && value < Infinity)) continue;
    const step255 = Math.round((255 * (value - low)) / (high - low || 1));
    rgba.set(kRamp.subarray(4 * step255, 4 * step255 + 4), 4 * i);
  }
  return { kind: "pixels", width, height, rgba };
}
