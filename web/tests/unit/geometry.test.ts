import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { planePose, rotationToX, turned } from "../../src/scene/geometry.js";
import { Series, kSpan } from "../../src/scene/series.js";
import type { FrameTransform, Vector } from "../../src/scene/types.js";
import { FrameTree } from "../../src/view/frame_tree.js";
import { niceAtLeast } from "../../src/panels/scale.js";

const directions: Vector[] = [[1, 0, 0], [-1, 0, 0], [0, 0, 1], [0, -1, 0], ...Array.from({ length: 50 }, (_, i): Vector => {
  const z = 1 - (2 * i + 1) / 50;
  const radius = Math.sqrt(1 - z * z);
  return [radius * Math.cos(2.4 * i), radius * Math.sin(2.4 * i), z];
})];

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
  for (const [value, end] of [[0.05, 0.05], [0.051, 0.1], [3, 5], [5.1, 10], [180, 200]] as const) assert.equal(niceAtLeast(value), end);
});
