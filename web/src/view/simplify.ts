/**
 * Fewer triangles for a picture: vertices that share a cell of a grid become one, at their mean (Rossignac and Borrel,
 * Multi-resolution 3D approximations for rendering complex scenes, 1993). Models have vertices every half millimetre,
 * which no picture of a table shows, and drawing in software pays for each.
 */

import type { Mesh } from "../scene/types.js";

/** A mesh of more than `most` vertices with cells of `cells` along its longest side; others, and soups, as they are. */
export function simplified(mesh: Mesh, most = 25_000, cells = 160): Mesh {
  const { positions, indices, colors } = mesh;
  const count = positions.length / 3;
  if (count <= most || !indices) return mesh;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i++) {
    const value = positions[i]!;
    if (!Number.isFinite(value)) return mesh;
    low[i % 3] = Math.min(low[i % 3]!, value);
    high[i % 3] = Math.max(high[i % 3]!, value);
  }
  const size = Math.max(high[0]! - low[0]!, high[1]! - low[1]!, high[2]! - low[2]!) / cells;
  if (!(size > 0)) return mesh;

  const clusters = new Map<number, number>();
  const clusterOf = new Uint32Array(count);
  const sums: number[] = []; // x, y, z, members
  const shades: number[] = [];
  for (let i = 0; i < count; i++) {
    let key = 0;
    for (let c = 0; c < 3; c++) key = key * (cells + 1) + Math.floor((positions[3 * i + c]! - low[c]!) / size);
    let cluster = clusters.get(key);
    if (cluster === undefined) {
      cluster = clusters.size;
      clusters.set(key, cluster);
      sums.push(0, 0, 0, 0);
      if (colors) shades.push(...colors.subarray(4 * i, 4 * i + 4)); // what a place rests on is no matter of means
    }
    clusterOf[i] = cluster;
    for (let c = 0; c < 3; c++) sums[4 * cluster + c]! += positions[3 * i + c]!;
    sums[4 * cluster + 3]!++;
  }
  const moved = new Float32Array(3 * clusters.size);
  for (let i = 0; i < clusters.size; i++)
    for (let c = 0; c < 3; c++) moved[3 * i + c] = sums[4 * i + c]! / sums[4 * i + 3]!;
  const kept = new Uint32Array(indices.length);
  let length = 0;
  for (let i = 0; i + 2 < indices.length; i += 3) {
    const [a, b, c] = [clusterOf[indices[i]!]!, clusterOf[indices[i + 1]!]!, clusterOf[indices[i + 2]!]!];
    if (a === b || b === c || c === a) continue;
    kept.set([a, b, c], length);
    length += 3;
  }
  return { positions: moved, indices: kept.slice(0, length), colors: colors ? Uint8Array.from(shades) : null };
}
