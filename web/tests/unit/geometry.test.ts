import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { planePose, rotationToX, turned } from "../../src/scene/geometry.js";
import { Series, kSpan } from "../../src/scene/series.js";
import type { FrameTransform, Vector } from "../../src/scene/types.js";
import { FrameTree } from "../../src/view/frame_tree.js";
import { simplified } from "../../src/view/simplify.js";
import { niceAtLeast } from "../../src/panels/scale.js";

const directions: Vector[] = [
  [1, 0, 0],
  [-1, 0, 0],
  [0, 0, 1],
  [0, -1, 0],
  ...Array.from({ length: 50 }, (_, i): Vector => {
    const z = 1 - (2 * i + 1) / 50;
    const radius = Math.sqrt(1 - z * z);
    return [radius * Math.cos(2.4 * i), radius * Math.sin(2.4 * i), z];
  }),
];

const near = (a: Vector, b: Vector): boolean => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) < 1e-9;

test("an arrow's rotation takes x to its direction, a plane's z to its normal", () => {
  for (const direction of directions) {
    assert.ok(near(turned(rotationToX(direction), [1, 0, 0]), direction), String(direction));
    const [x, y, z] = direction;
    const pose = planePose({ normal: { x: 2 * x, y: 2 * y, z: 2 * z }, offset: 0.5 })!;
    assert.ok(near(turned(pose.rotation, [0, 0, 1]), direction), String(direction));
    assert.ok(near(pose.position, [0.5 * x, 0.5 * y, 0.5 * z]));
  }
  assert.equal(planePose({ normal: { x: 0, y: 0, z: 0 } }), null);
  assert.equal(planePose({}), null);
});

test("frames follow their parents; a circle of them has no place", () => {
  const turn: FrameTransform["pose"] = { position: [1, 0, 0], rotation: [0, 0, Math.SQRT1_2, Math.SQRT1_2] };
  const frames = new Map<string, FrameTransform>([
    ["a", { parent: "world", pose: turn }],
    ["b", { parent: "a", pose: turn }],
    ["c", { parent: "d", pose: turn }],
    ["d", { parent: "c", pose: turn }],
  ]);
  const tree = new FrameTree(frames);
  const at = new Vector3(1, 0, 0).applyMatrix4(tree.world("b")!);
  assert.ok(near([at.x, at.y, at.z], [0, 1, 0])); // (1,0,0) -> in a (1,1,0) -> in the world (0,1,0)
  assert.equal(tree.world("c"), null);
  frames.set("c", { parent: "world", pose: turn });
  tree.refresh();
  assert.notEqual(tree.world("d"), null);
});

test("a series keeps peaks and its bounds, and begins anew when time does", () => {
  const series = new Series();
  for (let i = 0; i < 200_000; i++) series.add(i / 2000, i === 199_000 ? 50 : 1);
  assert.ok(series.length <= 4096);
  const values = Array.from({ length: series.length }, (_, i) => series.values[series.place(i)]!);
  assert.equal(Math.max(...values), 50);
  assert.ok(series.times[series.place(series.length - 1)]! - series.times[series.place(0)]! >= kSpan * 0.99);
  series.add(1, Number.NaN);
  series.add(1, 3);
  assert.deepEqual([series.length, series.last()], [1, 3]);
});

test("scales end at 1, 2 or 5 times a power of ten", () => {
  for (const [value, end] of [
    [0.05, 0.05],
    [0.051, 0.1],
    [3, 5],
    [5.1, 10],
    [180, 200],
  ] as const)
    assert.equal(niceAtLeast(value), end);
});

test("a mesh of too many vertices is drawn with fewer, within a cell of where they were, in colours it had", () => {
  const side = 200; // a wavy sheet of 40 000 vertices, 0.3 m wide
  const positions = new Float32Array(3 * side * side);
  const colors = new Uint8Array(4 * side * side);
  const height = (x: number, y: number): number => 0.01 * Math.sin(20 * x) * Math.cos(15 * y);
  const indices: number[] = [];
  for (let i = 0; i < side * side; i++) {
    const [x, y] = [(0.3 * (i % side)) / (side - 1), (0.3 * Math.floor(i / side)) / (side - 1)];
    positions.set([x, y, height(x, y)], 3 * i);
    colors.set(x < 0.15 ? [1, 2, 3, 255] : [9, 8, 7, 255], 4 * i);
    if (i % side < side - 1 && i < side * (side - 1)) indices.push(i, i + 1, i + side, i + 1, i + side + 1, i + side);
  }
  const mesh = { positions, indices: Uint32Array.from(indices), colors };
  const fewer = simplified(mesh, 25_000, 60);
  const count = fewer.positions.length / 3;
  assert.ok(count < 8000 && count > 2000, String(count));
  assert.ok(fewer.indices!.every((index) => index < count) && fewer.indices!.length < indices.length / 4);
  for (let i = 0; i < count; i++) {
    const [x, y, z] = fewer.positions.subarray(3 * i, 3 * i + 3) as unknown as [number, number, number];
    assert.ok(Math.abs(z - height(x, y)) < 0.005);
    assert.ok([1, 9].includes(fewer.colors![4 * i]!));
  }
  let area = 0; // of the sheet from above: nothing of it is lost
  for (let i = 0; i < fewer.indices!.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) =>
      fewer.positions.subarray(3 * fewer.indices![i + k]!, 3 * fewer.indices![i + k]! + 2),
    );
    area += Math.abs((b![0]! - a![0]!) * (c![1]! - a![1]!) - (c![0]! - a![0]!) * (b![1]! - a![1]!)) / 2;
  }
  assert.ok(Math.abs(area / 0.09 - 1) < 0.06, String(area));
  assert.equal(simplified(mesh, 50_000), mesh);
});
