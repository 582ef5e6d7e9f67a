// A small world as a graph would publish it: a table, three things on it, an arm of eight links that moves, pads,
// plans.

import { encode } from "./schemas.mjs";
import { centers, meshes, originColors, originOf } from "./shapes.mjs";

const second = 1_000_000_000n;
const identity = { position: { x: 0, y: 0, z: 0 }, orientation: { x: 0, y: 0, z: 0, w: 1 } };
const at = (x, y, z) => ({ position: { x, y, z }, orientation: { x: 0, y: 0, z: 0, w: 1 } });
export function objectsUpdate() {
  return encode("foxglove.SceneUpdate", {
    entities: meshes.map(({ points, indices }, i) => ({
      frameId: "world",
      id: `object/${i}`,
      metadata: [
        { key: "confidence", value: ["0.93", "0.81", "0.97"][i] },
        { key: "volume", value: ["0.000399", "0.000412", "0.000195"][i] },
        { key: "guessed_area", value: ["0.08", "0.11", "0.05"][i] },
        { key: "method", value: ["mirror", "rotation", "rotation"][i] },
        { key: "mass", value: i === 0 ? "0.31 – 0.42 kg" : "" },
      ],
      triangles: [
        {
          pose: identity,
          points,
          indices,
          color: originColors.guessed,
          colors: points.map((point) => originColors[originOf(point, centers[i], i)]),
        },
      ],
    })),
  });
}

export function tableUpdate() {
  return encode("foxglove.SceneUpdate", {
    entities: [
      {
        frameId: "world",
        id: "table",
        cubes: [
          { pose: at(0, 0, -0.01), size: { x: 0.9, y: 0.7, z: 0.02 }, color: { r: 0.72, g: 0.69, b: 0.64, a: 1 } },
        ],
      },
      ...["carton", "bottle", "ball"].map((name, i) => ({
        frameId: "world",
        id: `truth/${name}`,
        texts: [
          {
            pose: at(centers[i][0], centers[i][1], 0.2),
            billboard: true,
            fontSize: 14,
            scaleInvariant: true,
            color: { r: 0.9, g: 0.2, b: 0.2, a: 1 },
            text: name,
          },
        ],
      })),
    ],
  });
}

/** Points of the meshes that the camera sees, `count` of them, 20 bytes each. */
export function cloud(count) {
  const stride = 20;
  const data = Buffer.alloc(count * stride);
  const image = [
    [196, 64, 48],
    [62, 120, 170],
    [80, 150, 70],
  ];
  let random = 12345;
  const next = () => (random = (random * 1103515245 + 12345) & 0x7fffffff) / 0x7fffffff;
  for (let i = 0; i < count; i++) {
    const object = i % 3;
    const { points } = meshes[object];
    const point = points[Math.floor(next() * points.length)];
    const scatter = 0.0012;
    data.writeFloatLE(point.x + scatter * (next() - 0.5), i * stride);
    data.writeFloatLE(Math.min(point.y, centers[object][1]) + scatter * (next() - 0.5) - 0.001, i * stride + 4);
    data.writeFloatLE(point.z + 0.01 * (next() - 0.5), i * stride + 8);
    for (let c = 0; c < 3; c++) data[i * stride + 12 + c] = image[object][c];
    data[i * stride + 15] = 255;
    data.writeUInt16LE(object, i * stride + 16);
  }
  const fields = [
    ["x", 0, 7],
    ["y", 4, 7],
    ["z", 8, 7],
    ["red", 12, 1],
    ["green", 13, 1],
    ["blue", 14, 1],
    ["alpha", 15, 1],
    ["object", 16, 3],
  ];
  return encode("foxglove.PointCloud", {
    frameId: "world",
    pose: identity,
    pointStride: stride,
    fields: fields.map(([name, offset, type]) => ({ name, offset, type })),
    data,
  });
}

/** An arm of `links` links, as cylinders along z of their frames. */
export function robotUpdate(links = 8) {
  return encode("foxglove.SceneUpdate", {
    entities: Array.from({ length: links }, (_, i) => ({
      frameId: `link_${i}`,
      id: `robot/link_${i}`,
      frameLocked: true,
      cylinders: [
        {
          pose: at(0, 0, 0.05),
          size: { x: 0.07 - 0.005 * (i % 8), y: 0.07 - 0.005 * (i % 8), z: 0.1 },
          bottomScale: 1,
          topScale: 0.85,
          color: { r: 0.86, g: 0.47, b: 0.16, a: 1 },
        },
      ],
    })),
  });
}

export function frames(time, links = 8) {
  const transforms = [
    {
      parentFrameId: "world",
      childFrameId: "camera",
      translation: { x: 0, y: -0.7, z: 0.5 },
      rotation: { x: -0.854, y: 0, z: 0, w: 0.52 },
    },
  ];
  for (let i = 0; i < links; i++) {
    const angle = i === 0 ? 0 : 0.28 + 0.12 * Math.sin(time + i);
    transforms.push({
      parentFrameId: i === 0 ? "world" : `link_${i - 1}`,
      childFrameId: `link_${i}`,
      translation: i === 0 ? { x: -0.02, y: 0.42, z: 0 } : { x: 0, y: 0, z: 0.1 },
      rotation: { x: Math.sin(angle / 2), y: 0, z: 0, w: Math.cos(angle / 2) },
    });
  }
  return encode("foxglove.FrameTransforms", { transforms });
}

const rejections = [
  { reason: "the arm cannot reach it", count: 214, generator: "antipodal", nearestMiss: "12 mm out of reach" },
  { reason: "the hand would hit the table", count: 131, generator: "circles", nearestMiss: "3.1 mm" },
  { reason: "the opening is too small", count: 88, generator: "boxes", nearestMiss: "74.0 mm > 69.0 mm" },
  { reason: "the contact is on guessed surface", count: 17, generator: "antipodal", nearestMiss: "0.62 > 0.50" },
];

function tactile(name, force, columns = 6, rows = 14) {
  const intensity = Array.from({ length: rows * columns }, (_, i) => {
    const [row, column] = [Math.floor(i / columns), i % columns];
    const distance = ((row - 5) / 3.2) ** 2 + ((column - 2.6) / 1.7) ** 2;
    return Math.round(1800 * force * Math.exp(-distance));
  });
  const newtonPerCount = 0.0002;
  return {
    header: { frameId: name },
    rows,
    columns,
    fullScale: 4095,
    intensity,
    sum: newtonPerCount * intensity.reduce((sum, count) => sum + count, 0),
    newtonPerCount,
  };
}

/** Sine and cosine of half a right angle. */
const half = Math.SQRT1_2;

function graspOf(object, rank) {
  const [x, y] = centers[object];
  const z = 0.06 + 0.012 * rank;
  return {
    // The gripper's z is the approach: downward and forward by turns.
    XWG: {
      position: { x, y, z },
      orientation: rank % 2 === 0 ? { w: 0, x: 1, y: 0, z: 0 } : { w: half, x: -half, y: 0, z: 0 },
    },
    approachDirection: rank % 2 === 0 ? { x: 0, y: 0, z: -1 } : { x: 0, y: 1, z: 0 },
    pregraspOpening: 0.068,
    pregraspDistance: 0.09,
    graspForce: 12,
    quality: 0.21 - 0.019 * rank,
    robustness: 0.96 - 0.05 * rank,
    guessedContact: 0.04 * rank,
    generator: rank % 2 === 0 ? "circles" : "antipodal",
    contacts: [
      { x: x - 0.033, y, z },
      { x: x + 0.033, y, z },
    ],
    predicted: {
      pads: ["left_pad", "right_pad"].map((name) => ({ image: tactile(name, 0.9), contactArea: 2e-4 })),
      tactileSum: 12,
    },
  };
}

/** The plan of object 0, 1 or 2; that of 2 has no grasp. */
export function plan(object, stamp = second) {
  const grasps = object === 2 ? [] : Array.from({ length: object === 0 ? 8 : 3 }, (_, rank) => graspOf(object, rank));
  return encode("prehend.msgs.GraspPlan", {
    header: { stamp, frameId: "world" },
    id: object,
    grasps,
    rejections,
    candidates: 450 + grasps.length,
    outcome: grasps.length > 0 ? 2 : 1,
    problem: object === 2 ? "no candidate passes: the arm cannot reach 214 of 450" : "",
    remedies: object === 2 ? [{ text: "with 6 mm more opening (75 mm): 12 grasps", grasps: 12 }] : [],
    choices: grasps.slice(0, 2).map((_, i) => ({
      act: 1,
      grasp: i,
      success: 0.93 - 0.04 * i,
      worth: 84 - i,
      text: `grasp it now: lifted with ${(0.93 - 0.04 * i).toFixed(2)}, worth ${84 - i} s`,
    })),
  });
}

/** The same objects as the graph's own models, for recordings without well-known types. */
export function model(object, stamp = second) {
  const { points, indices } = meshes[object];
  const data = Buffer.alloc(12 * points.length + 4 * indices.length);
  points.forEach((point, i) => ["x", "y", "z"].forEach((axis, c) => data.writeFloatLE(point[axis], 12 * i + 4 * c)));
  indices.forEach((index, i) => data.writeUInt32LE(index, 12 * points.length + 4 * i));
  const origins = { seen: 0, mirrored: 1, guessed: 2, touched: 3 };
  return encode("prehend.msgs.ObjectModel", {
    header: { stamp, frameId: "world" },
    id: object,
    valid: true,
    mesh: { vertexCount: points.length, triangleCount: indices.length / 3, data },
    vertexOrigin: Uint8Array.from(points, (point) => origins[originOf(point, centers[object], object)]),
    volume: 4e-4,
    confidence: 0.9,
    method: "mirror",
    mass: { low: 0.3, high: 0.4 },
  });
}

export function hypotheses(stamp = second, points = 300) {
  const objects = centers.map((center, id) => {
    const data = Buffer.alloc(16 * points);
    for (let i = 0; i < points; i++) {
      const vertex = meshes[id].points[(7 * i) % meshes[id].points.length];
      ["x", "y", "z"].forEach((axis, c) => data.writeFloatLE(vertex[axis], 16 * i + 4 * c));
      data[16 * i + 12] = 200;
    }
    return { id, cloud: { count: points, stride: 16, hasColor: true, data } };
  });
  return encode("prehend.msgs.ObjectHypotheses", {
    header: { stamp, frameId: "world" },
    camera: { XWC: { position: { x: 0, y: -0.7, z: 0.5 }, orientation: { w: 0.52, x: -0.854, y: 0, z: 0 } } },
    table: { normal: { x: 0, y: 0, z: 1 }, offset: 0 },
    objects,
  });
}

const phases = [1, 3, 4, 5, 6, 7, 8];
/** What is published again and again at time [s], as [topic, type, bytes]. */
export function signalsAt(time) {
  const stamp = BigInt(Math.round(time * 1e9));
  const header = { stamp, frameId: "wrist" };
  const force = Math.max(0, Math.sin(0.35 * time)) ** 2;
  return [
    [
      "/tactile/left",
      "prehend.msgs.TactileFrame",
      encode("prehend.msgs.TactileFrame", { ...tactile("left_pad", force), header: { stamp, frameId: "left_pad" } }),
    ],
    [
      "/tactile/right",
      "prehend.msgs.TactileFrame",
      encode("prehend.msgs.TactileFrame", {
        ...tactile("right_pad", 0.92 * force),
        header: { stamp, frameId: "right_pad" },
      }),
    ],
    [
      "/wrench",
      "prehend.msgs.Wrench",
      encode("prehend.msgs.Wrench", {
        header,
        wrench: {
          force: {
            x: 0.4 * Math.sin(3 * time),
            y: 0.3 * Math.cos(2.2 * time),
            z: -3.4 * force + 0.1 * Math.sin(9 * time),
          },
          torque: { x: 0.03 * Math.sin(time), y: 0.02 * Math.cos(time), z: 0.01 * force },
        },
      }),
    ],
    [
      "/gripper/state",
      "prehend.msgs.GripperState",
      encode("prehend.msgs.GripperState", { header, opening: 0.068 - 0.02 * force }),
    ],
  ];
}

/** The cycle's words up to time [s], as [time, topic, type, bytes]. */
export function eventsUntil(time) {
  const events = [];
  phases.forEach((phase, i) => {
    const begin = 2 + 3 * i;
    events.push([
      begin,
      "/cycle/state",
      "prehend.msgs.CycleState",
      encode("prehend.msgs.CycleState", {
        header: { stamp: BigInt(begin) * second },
        phase,
        objectId: 0,
        graspIndex: 0,
        detail: phase === 3 ? "along a straight way, 90 mm" : "",
        taskState: "pick",
      }),
    ]);
  });
  const surprise = (begin, kind, predicted, felt, tolerance, surprising, reaction) =>
    events.push([
      begin,
      "/surprise",
      "prehend.msgs.Surprise",
      encode("prehend.msgs.Surprise", {
        header: { stamp: BigInt(Math.round(begin * 1e9)) },
        kind,
        predicted,
        felt,
        tolerance,
        surprising,
        reaction,
      }),
    ]);
  surprise(8.5, 0, 0.0672, 0.0664, 0.004, false, "");
  surprise(9.4, 2, 12, 17.8, 3, true, "the grip is loosened to 12 N");
  surprise(11.5, 3, 1, 1, 0.5, false, "");
  surprise(14.2, 11, 0, 0.0031, 0.002, true, "it presses harder: 15 N");
  return events.filter(([begin]) => begin <= time).sort((a, b) => a[0] - b[0]);
}

export function diagnostics() {
  return [
    ["simulation", 0, "real time factor 1.0"],
    ["stereo_segmentation", 0, "3 objects in 0.21 s"],
    ["grasp_planning", 1, "object 2: no candidate passes"],
    ["grasp_cycle", 0, "lifting object 0"],
  ].map(([node, level, text]) => encode("prehend.msgs.graph.Diagnostic", { stamp: second, node, level, text }));
}

/** An image of `width` x `height` pixels. */
export function picture(width = 160, height = 120) {
  const data = Buffer.alloc(3 * width * height);
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) data.set([70 + x / 2, 90 + y / 2, 120], 3 * (y * width + x));
  return encode("foxglove.RawImage", { width, height, encoding: "rgb8", step: 3 * width, data, frameId: "camera" });
}

export function stopState(stopped) {
  return encode("prehend.msgs.EmergencyStop", {
    stopped,
    source: stopped ? "viewer" : "",
    reason: stopped ? "stopped on the viewer's page" : "",
    since: 12n * second,
    count: stopped ? 1n : 0n,
  });
}
