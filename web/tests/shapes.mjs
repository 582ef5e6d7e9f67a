// The things of the tests' world: their meshes, and what each place of these rests on.

export const originColors = {
  seen: { r: 0.3, g: 0.69, b: 0.31, a: 1 },
  mirrored: { r: 0.13, g: 0.59, b: 0.95, a: 1 },
  touched: { r: 1, g: 0.6, b: 0, a: 1 },
  guessed: { r: 0.62, g: 0.62, b: 0.62, a: 1 },
};

/** Vertices and triangles of a solid of revolution about z. */
function revolved(profile, center, slices = 48) {
  const points = [];
  const indices = [];
  for (const [radius, z] of profile) {
    for (let i = 0; i < slices; i++) {
      const angle = (2 * Math.PI * i) / slices;
      points.push({ x: center[0] + radius * Math.cos(angle), y: center[1] + radius * Math.sin(angle), z });
    }
  }
  for (let ring = 0; ring + 1 < profile.length; ring++) {
    for (let i = 0; i < slices; i++) {
      const [a, b] = [ring * slices + i, ring * slices + ((i + 1) % slices)];
      indices.push(a, b, a + slices, b, b + slices, a + slices);
    }
  }
  return { points, indices };
}

const profiles = [
  Array.from({ length: 12 }, (_, i) => [
    i === 0 || i === 11 ? 1e-4 : 0.034,
    (0.11 * Math.min(Math.max(i - 1, 0), 9)) / 9,
  ]),
  [
    [1e-4, 0],
    ...Array.from({ length: 14 }, (_, i) => [
      i < 8 ? 0.031 : i < 11 ? 0.031 - 0.006 * (i - 7) : 0.013,
      (0.18 * i) / 13,
    ]),
    [1e-4, 0.18],
  ],
  Array.from({ length: 17 }, (_, i) => [
    Math.max(1e-4, 0.036 * Math.sin((Math.PI * i) / 16)),
    0.036 - 0.036 * Math.cos((Math.PI * i) / 16),
  ]),
];
export const centers = [
  [-0.14, 0.07, 0],
  [0.02, -0.1, 0],
  [0.16, 0.08, 0],
];

export const meshes = profiles.map((profile, i) => revolved(profile, centers[i]));

/** "seen", "mirrored", "touched" or "guessed". */
export function originOf(point, center, object) {
  if (point.z < 0.004) return "guessed";
  if (object === 0 && point.z > 0.07 && point.y < center[1] - 0.025) return "touched";
  return point.y < center[1] + 0.006 ? "seen" : "mirrored";
}
