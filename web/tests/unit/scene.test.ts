import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { isShown } from "../../src/scene/ingest.js";
import { kOrigins } from "../../src/scene/types.js";
import { encode, Taken } from "./testing.js";
// @ts-expect-error: plain JavaScript, shared with the browser's tests
import * as world from "../world.mjs";

const second = 1_000_000_000n;
const identity = { position: {}, orientation: { w: 1 } };

test("a mesh of well-known type and the graph's own model have the same vertices, triangles and colours", () => {
  const known = new Taken().take("/viewer/objects", "foxglove.SceneUpdate", world.objectsUpdate());
  const own = new Taken().take("/models", "prehend.msgs.ObjectModel", world.model(0));
  const [a, b] = [
    known.store.entities.get("/viewer/objects")?.get("object/0"),
    own.store.entities.get("raw models")?.get("object/0"),
  ];
  const [first, other] = [a?.primitives[0], b?.primitives[0]];
  assert.ok(first?.kind === "mesh" && other?.kind === "mesh");
  assert.deepEqual([...first.mesh.positions], [...other.mesh.positions]);
  assert.deepEqual([...first.mesh.indices!], [...other.mesh.indices!]);
  assert.deepEqual([...first.mesh.colors!], [...other.mesh.colors!]);
  const used = new Set<string>();
  for (let i = 0; i < first.mesh.colors!.length; i += 4) used.add([...first.mesh.colors!.slice(i, i + 4)].join());
  const expected = kOrigins.map(({ color }) => color.map((value) => Math.round(255 * value)).join());
  assert.deepEqual([...used].sort(), [...expected].sort());
  assert.deepEqual([...known.troubles, ...own.troubles], []);
  assert.equal(known.store.objects.get(0)?.confidence, 0.93);
  assert.equal(own.store.objects.get(0)?.method, "mirror");
});

test("a plan's grasps have their chance of success, and its ledger is sorted by what it cost", () => {
  const { store } = new Taken()
    .take("/plans", "prehend.msgs.GraspPlan", world.plan(0))
    .take("/plans", "prehend.msgs.GraspPlan", world.plan(2));
  const plan = store.plans.get(0)!;
  assert.equal(plan.grasps.length, 8);
  assert.equal(plan.grasps[0]!.success, 0.93);
  assert.equal(plan.grasps[5]!.success, undefined);
  assert.ok(Math.abs(plan.grasps[5]!.robustness! - 0.71) < 1e-12);
  assert.equal(plan.grasps[0]!.predicted.get("left_pad")?.rows, 14);
  const counts = plan.rejections.map((rejection) => rejection.count);
  assert.deepEqual(
    counts,
    [...counts].sort((a, b) => b - a),
  );
  const none = store.plans.get(2)!;
  assert.equal(none.outcome, "ungraspable");
  assert.match(none.remedies[0]!, /6 mm more opening/);
  assert.equal(store.entities.get("raw plans")?.size, 8);
});

test("a later view takes away what was of the one before; an earlier one is not shown any more", () => {
  const taken = new Taken();
  taken
    .take("/models", "prehend.msgs.ObjectModel", world.model(0, 5n * second))
    .take("/plans", "prehend.msgs.GraspPlan", world.plan(1, 5n * second));
  taken.take("/models", "prehend.msgs.ObjectModel", world.model(2, 4n * second));
  assert.deepEqual([...taken.store.objects.keys()].sort(), [0, 1]);
  taken.take("/plans", "prehend.msgs.GraspPlan", world.plan(1, 6n * second));
  assert.deepEqual([...taken.store.objects.keys()], [1]);
  assert.equal(taken.store.entities.get("raw models"), undefined);
});

test("grasps that a server draws are not drawn again from the plan", () => {
  const taken = new Taken().take("/plans", "prehend.msgs.GraspPlan", world.plan(0));
  taken.take("/viewer/grasps", "foxglove.SceneUpdate", {
    entities: [{ id: "grasp/0/0", frameId: "world", metadata: [{ key: "quality", value: "0.1" }] }],
  });
  taken.take("/plans", "prehend.msgs.GraspPlan", world.plan(1));
  assert.equal(taken.store.entities.get("raw plans"), undefined);
  assert.equal(taken.store.plans.get(0)!.grasps.length, 8); // the plan says more than the entity
});

test("clouds are read with aligned and unaligned points, with colour and object", () => {
  for (const stride of [18, 20]) {
    const data = Buffer.alloc(2 * stride);
    for (const [i, x] of [0.25, -1.5].entries()) {
      data.writeFloatLE(x, i * stride);
      data.writeFloatLE(2 * x, i * stride + 4);
      data.writeFloatLE(3 * x, i * stride + 8);
      data.set([10, 20, 30, 255], i * stride + 12);
      data.writeUInt16LE(i === 0 ? 7 : 65535, i * stride + 16);
    }
    const fields = [
      ["x", 0, 7],
      ["y", 4, 7],
      ["z", 8, 7],
      ["red", 12, 1],
      ["green", 13, 1],
      ["blue", 14, 1],
      ["object", 16, 3],
    ];
    const { store, troubles } = new Taken().take("/viewer/cloud", "foxglove.PointCloud", {
      frameId: "world",
      pose: identity,
      pointStride: stride,
      data,
      fields: fields.map(([name, offset, type]) => ({ name, offset, type })),
    });
    assert.deepEqual(troubles, []);
    assert.deepEqual([...store.cloud!.positions], [0.25, 0.5, 0.75, -1.5, -3, -4.5]);
    assert.deepEqual([...store.cloud!.colors!], [10, 20, 30, 255, 10, 20, 30, 255]);
    assert.deepEqual([...store.cloud!.objects!], [7, 65535]);
  }
});

test("the view of objects gives the cloud by object, the table and the camera", () => {
  const { store } = new Taken().take("/objects", "prehend.msgs.ObjectHypotheses", world.hypotheses());
  assert.equal(store.cloud?.count, 900);
  assert.deepEqual([...new Set(store.cloud!.objects!)], [0, 1, 2]);
  assert.ok(store.entities.get("raw /objects")?.has("table"));
  assert.equal(store.frames.get("camera")?.pose.position[1], -0.7);
});

test("pads, wrench, surprise, phases, stop and health come in", () => {
  const taken = new Taken();
  for (const [topic, type, data] of world.signalsAt(4)) taken.take(topic, type, data);
  for (const [time, topic, type, data] of world.eventsUntil(30))
    taken.take(topic, type, data, BigInt(Math.round(time * 1e9)));
  for (const data of world.diagnostics()) taken.take("/diagnostics", "prehend.msgs.graph.Diagnostic", data);
  taken.take("/emergency_stop", "prehend.msgs.EmergencyStop", world.stopState(true));
  const { store } = taken;
  assert.deepEqual(taken.troubles, []);
  const pad = store.pads.get("left_pad")!;
  const sum = pad.forces.reduce((total, force) => total + force, 0);
  assert.ok(Math.abs(sum - pad.sum) < 1e-3 * sum && sum > 1);
  assert.ok(Math.abs(store.series.get("wrench Fx")!.last()! - 0.4 * Math.sin(12)) < 1e-6);
  assert.deepEqual(
    store.surprises.map((mark) => mark.surprising),
    [false, true, false, true],
  );
  assert.equal(store.surprises[3]!.felt, "3.1 mm");
  assert.deepEqual(
    store.phases.map((mark) => mark.phase),
    ["waiting", "approach", "grasp", "lift", "move", "release", "done"],
  );
  assert.equal(store.diagnostics.get("grasp_planning")?.level, "warning");
  assert.deepEqual([store.stop?.stopped, store.stop?.since], [true, 12]);
  // What is latched comes once more after a connection came back.
  for (const [, topic, type, data] of world.eventsUntil(30)) taken.take(topic, type, data);
  assert.deepEqual([store.surprises.length, store.phases.length], [4, 7]);
});

test("messages that contradict themselves are said in words and change nothing", () => {
  const taken = new Taken();
  const bad: [string, string, object][] = [
    [
      "/models",
      "prehend.msgs.ObjectModel",
      { id: 1, mesh: { vertexCount: 4_000_000_000, triangleCount: 1, data: new Uint8Array(24) } },
    ],
    [
      "/models",
      "prehend.msgs.ObjectModel",
      { id: 1, mesh: { vertexCount: 1, triangleCount: 1, data: new Uint8Array(24).fill(9) } },
    ],
    [
      "/objects",
      "prehend.msgs.ObjectHypotheses",
      { objects: [{ cloud: { count: 5, stride: 4, data: new Uint8Array(20) } }] },
    ],
    ["/viewer/cloud", "foxglove.PointCloud", { pointStride: 7, data: new Uint8Array(20) }],
    [
      "/viewer/cloud",
      "foxglove.PointCloud",
      { pointStride: 10, data: new Uint8Array(20), fields: [{ name: "x", offset: 8, type: 7 }] },
    ],
    ["/viewer/image/left", "foxglove.RawImage", { width: 4_000_000_000, height: 4_000_000_000, encoding: "rgb8" }],
    ["/viewer/image/left", "foxglove.RawImage", { width: 40, height: 40, encoding: "rgb8", data: new Uint8Array(3) }],
    [
      "/viewer/image/left",
      "foxglove.RawImage",
      { width: 1, height: 1, encoding: "constructor", data: new Uint8Array(3) },
    ],
    ["/camera/stereo", "prehend.msgs.StereoPair", { width: 4, height: 4, channels: 3, data: new Uint8Array(3) }],
    ["/tactile/left", "prehend.msgs.TactileFrame", { rows: 65_000, columns: 65_000, intensity: [1] }],
    ["/x", "foxglove.SceneUpdate", { entities: [{ id: "e", triangles: [{ points: [{}], indices: [0, 1, 2] }] }] }],
  ];
  for (const [topic, type, message] of bad) {
    const before = taken.troubles.length;
    taken.take(topic, type, message);
    assert.equal(taken.troubles.length, before + 1, `${type} ${JSON.stringify(Object.keys(message))}`);
    assert.ok(taken.troubles.at(-1)!.startsWith(topic));
  }
  assert.equal(taken.store.cloud, null);
  assert.equal(taken.store.pictures.size + taken.store.pads.size, 0);
});

test("random bytes of every type are messages or words, and a damaged schema is said once", () => {
  const taken = new Taken();
  let state = 3;
  const random = (): number => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
  const types = [
    "foxglove.SceneUpdate",
    "foxglove.PointCloud",
    "foxglove.FrameTransforms",
    "prehend.msgs.GraspPlan",
    "prehend.msgs.TactileFrame",
    "prehend.msgs.Wrench",
    "prehend.msgs.CycleState",
  ];
  const seeds = [world.objectsUpdate(), world.cloud(50), world.frames(1), world.plan(0)];
  for (let i = 0; i < 1500; i++) {
    const type = types[i % types.length]!;
    const data =
      i % 2 === 0
        ? Uint8Array.from({ length: 60 * random() }, () => 256 * random())
        : Uint8Array.from(seeds[i % seeds.length]!.slice(0, 3000));
    for (let k = 0; k < 3 && data.length > 0; k++) data[Math.floor(random() * data.length)] = 256 * random();
    taken.take("/t", type, data);
  }
  assert.ok(taken.store.frames.size <= 5000);
  const damaged = new Taken();
  for (let i = 0; i < 3; i++) {
    damaged.ingest.take(
      "k",
      { topic: "/t", schemaName: "foxglove.PointCloud", encoding: "protobuf" },
      () => Uint8Array.of(1, 2, 3),
      0n,
      new Uint8Array(),
    );
  }
  assert.equal(damaged.troubles.length, 1);
  assert.match(damaged.troubles[0]!, /schema/);
});

test("what is subscribed to is shown, and nothing twice", () => {
  const raw = { topic: "/objects", schemaName: "prehend.msgs.ObjectHypotheses", encoding: "protobuf" };
  const converted = { topic: "/viewer/cloud", schemaName: "foxglove.PointCloud", encoding: "protobuf" };
  assert.equal(isShown(raw, [raw]), true);
  assert.equal(isShown(raw, [raw, converted]), false);
  assert.equal(isShown(converted, [raw, converted]), true);
  assert.equal(isShown({ ...raw, encoding: "json" }, [raw]), false);
  assert.equal(isShown({ ...raw, schemaName: "toString" }, [raw]), false);
});

test("frames of the schema with fields that this page does not know are read", () => {
  const data = Buffer.concat([
    encode("prehend.msgs.Clock", { time: 7n * second, speed: 1 }),
    Buffer.from([0xfa, 0x3f, 2, 1, 2]),
  ]);
  assert.equal(new Taken().take("/clock", "prehend.msgs.Clock", data).store.time, 7);
});

test("vertices taken out of a scene are those that were put in, and what else it says stays", () => {
  const points = [{ x: 1, y: 2, z: 3 }, { x: 4 }, {}, { z: -0.5 }];
  const colors = [{ r: 1, a: 1 }, { g: 0.5, a: 1 }, {}, { r: 2, g: -1, b: 0.2, a: 1 }];
  const message = encode("foxglove.SceneUpdate", {
    deletions: [{ id: "gone" }],
    entities: [
      {
        id: "a",
        frameId: "f",
        metadata: [{ key: "k", value: "v" }],
        triangles: [
          { points, colors, indices: [0, 1, 2, 2, 1, 3], pose: { position: { x: 9 }, orientation: { w: 1 } } },
          { points: points.slice(0, 3), color: { g: 1, a: 1 } },
        ],
      },
      { id: "b", cubes: [{ size: { x: 1, y: 1, z: 1 }, color: { a: 1 } }] },
    ],
  });
  const { store, troubles } = new Taken().take("/t", "foxglove.SceneUpdate", message);
  assert.deepEqual(troubles, []);
  const [a, b] = [store.entities.get("/t")!.get("a")!, store.entities.get("/t")!.get("b")!];
  const [first, second] = a.primitives;
  assert.ok(first?.kind === "mesh" && second?.kind === "mesh" && b.primitives[0]?.kind === "cube");
  assert.deepEqual([...first.mesh.positions], [1, 2, 3, 4, 0, 0, 0, 0, 0, 0, 0, -0.5]);
  assert.deepEqual([...first.mesh.colors!], [255, 0, 0, 255, 0, 128, 0, 255, 0, 0, 0, 0, 255, 0, 51, 255]);
  assert.deepEqual([...first.mesh.indices!], [0, 1, 2, 2, 1, 3]);
  assert.deepEqual(
    [first.pose.position[0], second.color[1], second.mesh.indices, a.metadata.get("k"), a.frame],
    [9, 1, null, "v", "f"],
  );
  // Cut off anywhere it is an error in words or a shorter message, never anything else.
  for (let length = 0; length < message.length; length++) {
    new Taken().take("/t", "foxglove.SceneUpdate", message.slice(0, length));
  }
});

test("a stage's hand is sketched where its joints are, as far open as the gripper says; another robot's is not", () => {
  const taken = new Taken().take("/joint_states", "prehend.msgs.JointState", { name: ["arm_joint_1"], position: [1] });
  assert.equal(taken.store.entities.size, 0);
  taken.take("/gripper/state", "prehend.msgs.GripperState", { opening: 0.03 });
  const name = ["arm_yaw", "arm_x", "arm_y", "arm_z"];
  taken.take("/joint_states", "prehend.msgs.JointState", { name, position: [Math.PI / 2, 0.1, -0.2, 0.3] });
  const pose = taken.store.frames.get("stage hand")!.pose;
  assert.deepEqual(pose.position, [0.1, -0.2, 0.3]);
  assert.ok(Math.abs(pose.rotation[2] - Math.SQRT1_2) < 1e-12);
  const fingers = taken.store.entities.get("sketched hand")!.get("hand/sketch")!.primitives.slice(0, 2);
  const inner = fingers.map((finger) =>
    finger.kind === "cube" ? Math.abs(finger.pose.position[1]) - finger.size[1] / 2 : 0,
  );
  for (const half of inner) assert.ok(Math.abs(half - 0.015) < 1e-9);
});

test("every phase of the cycle that the schema has is named on the page", () => {
  const schema = readFileSync("../msgs/grasp.proto", "utf8");
  const phases = /message CycleState \{\s*enum Phase \{[^\n]*\n([^}]*)\}/.exec(schema)![1]!;
  const values = [...phases.matchAll(/(\w+) = (\d+);/g)].filter(([, , value]) => value !== "0");
  assert.ok(values.length >= 10);
  for (const [, name, value] of values) {
    const { store } = new Taken().take("/cycle/state", "prehend.msgs.CycleState", { phase: Number(value) });
    assert.equal(store.phases.at(-1)?.phase, name!.toLowerCase());
  }
});
