/**
 * The hand of a stage (config/robots/stage_pg70.urdf) out of its joints alone, whose values are where the middle of
 * the pads is and how they are turned. A sketch, for recordings of the graph's own topics: they have no geometry of
 * the robot.
 */

import { numbers, texts } from "../protobuf/fields.js";
import type { Handlers } from "./handler.js";
import type { Color, Primitive, Vector } from "./types.js";

const kJoints = ["arm_x", "arm_y", "arm_z", "arm_yaw"];
const kFrame = "stage hand";
const kTopic = "sketched hand";
const kGrey: Color = [0.55, 0.58, 0.61, 1];
const kDark: Color = [0.3, 0.33, 0.36, 1];
const kOpening = 0.069; // m, until the gripper says its own

function box(position: Vector, size: Vector, color: Color): Primitive {
  return { kind: "cube", pose: { position, rotation: [0, 0, 0, 1] }, size, color };
}

/**
 * The fingers, open by `opening` [m] along y, the palm over them and the quill that carries it. Rough sizes of a
 * PG70.
 */
function hand(opening: number): Primitive[] {
  return [
    ...[-1, 1].map((side) => box([0, side * (opening / 2 + 0.006), 0.02], [0.026, 0.012, 0.085], kDark)),
    box([0, 0, 0.098], [0.07, 0.15, 0.07], kGrey),
    {
      kind: "cylinder",
      pose: { position: [0, 0, 0.26], rotation: [0, 0, 0, 1] },
      size: [0.06, 0.06, 0.25],
      bottomScale: 1,
      topScale: 1,
      color: kGrey,
    },
  ];
}

export const kStageHandlers: Handlers = {
  "prehend.msgs.JointState": (store, { fields }) => {
    const names = texts(fields, "name");
    const positions = numbers(fields, "position");
    const [x, y, z, yaw] = kJoints.map((joint) => positions[names.indexOf(joint)]);
    if (x === undefined || y === undefined || z === undefined || yaw === undefined) return; // another robot
    const rotation = [0, 0, Math.sin(yaw / 2), Math.cos(yaw / 2)] as [number, number, number, number];
    store.frames.set(kFrame, { parent: "world", pose: { position: [x, y, z], rotation } });
    store.touch("frames");
    const opening = store.series.get("gripper opening")?.last() ?? kOpening;
    const drawn = store.entities.get(kTopic)?.get("hand/sketch")?.metadata.get("opening");
    const millimetres = (1000 * opening).toFixed(1);
    if (drawn === millimetres) return;
    const metadata = new Map([["opening", millimetres]]);
    store.setEntity(kTopic, { id: "hand/sketch", frame: kFrame, primitives: hand(opening), metadata });
  },
};
