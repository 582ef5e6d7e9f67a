/**
 * What the page shows, whatever it came from: live channels of well-known types, raw messages of the graph, or a
 * recording of either. Metres, radians, newtons; right-handed frames; quaternions x, y, z, w.
 */

export type Vector = [x: number, y: number, z: number];
export type Rotation = [x: number, y: number, z: number, w: number];
/** Red, green, blue and opacity, each 0 to 1. */
export type Color = [red: number, green: number, blue: number, alpha: number];

/** Maps points of the child frame into the parent frame. */
export interface Pose {
  position: Vector;
  rotation: Rotation;
}

export interface Mesh {
  positions: Float32Array; // vertices x 3, m
  indices: Uint32Array | null; // triangles x 3; null: the vertices are three a triangle
  colors: Uint8Array | null; // vertices x 4; null: one colour for all
}

export type Primitive =
  | { kind: "mesh"; pose: Pose; mesh: Mesh; color: Color }
  | {
      kind: "arrow"; // from the pose's origin along its x
      pose: Pose;
      shaftLength: number;
      shaftDiameter: number;
      headLength: number;
      headDiameter: number;
      color: Color;
    }
  | { kind: "cube"; pose: Pose; size: Vector; color: Color }
  | { kind: "sphere"; pose: Pose; size: Vector; color: Color }
  | { kind: "cylinder"; pose: Pose; size: Vector; bottomScale: number; topScale: number; color: Color }
  | { kind: "line"; pose: Pose; shape: "strip" | "loop" | "list"; points: Float32Array; color: Color }
  // `size` in m, or in pixels of the same size from everywhere.
  | { kind: "text"; pose: Pose; text: string; size: number; isScaleInvariant: boolean; color: Color }
  | { kind: "model"; pose: Pose; scale: Vector; color: Color | null; mediaType: string; data: Uint8Array };

/** Something drawn, by its id: `table`, `object/3`, `grasp/3/0`, `robot/link_1`. */
export interface Entity {
  id: string;
  frame: string;
  primitives: Primitive[];
  metadata: ReadonlyMap<string, string>;
}

export interface Cloud {
  frame: string;
  count: number;
  positions: Float32Array; // count x 3, m
  colors: Uint8Array | null; // count x 4, of the image
  objects: Uint16Array | null; // count, 65535: of none
}

export interface FrameTransform {
  parent: string;
  pose: Pose;
}

/** Pixels as they are shown: rgba, 4 bytes each; or compressed in a format that the browser reads. */
export type Picture =
  | { kind: "pixels"; width: number; height: number; rgba: Uint8ClampedArray<ArrayBuffer> }
  | { kind: "compressed"; blob: Blob };

/** The forces on the cells of a tactile pad, row 0 nearest the fingertip. */
export interface PadImage {
  rows: number;
  columns: number;
  forces: Float32Array; // rows x columns, N
  sum: number; // N
}

/** What is known of an object beside its shape. Absent: nobody said it. */
export interface ObjectInfo {
  id: number;
  problem: string;
  confidence?: number; // 0..1, that the shape is right
  volume?: number; // m^3
  guessedArea?: number; // share of the area that was neither seen nor touched
  method?: string; // of its completion
  known?: string; // name of the known object that it was found to be
  details: { name: string; value: string }[];
}

export interface GraspInfo {
  object: number;
  rank: number; // 0 is the best
  quality?: number; // epsilon of the grasp wrench space
  success?: number; // probability that it is lifted
  robustness?: number; // share of disturbed cases in which it holds
  guessedContact?: number; // share of the contact on surface nobody saw
  width?: number; // m, between the pads before it closes
  generator: string;
  remark: string;
  contacts: Vector[]; // m, world; none: not known
  predicted: ReadonlyMap<string, PadImage>; // by the pad's name
}

export interface Rejection {
  reason: string;
  count: number;
  generator: string;
  nearestMiss: string;
}

/** The grasps of one object, best first, and the ledger of what was tried. */
export interface Plan {
  object: number;
  stamp: bigint; // ns, of the view it was planned on
  outcome: "failed" | "ungraspable" | "graspable";
  problem: string;
  candidates: number;
  grasps: GraspInfo[];
  rejections: Rejection[];
  remedies: string[];
  choices: string[];
}

export interface SurpriseMark {
  time: number; // s
  name: string;
  predicted: string;
  felt: string;
  surprising: boolean;
  bits?: number;
  reaction: string;
}

export interface PhaseMark {
  time: number; // s
  phase: string;
  detail: string;
  object: number;
  grasp: number;
}

export type Level = "debug" | "info" | "warning" | "error";

export interface LogEntry {
  time: number; // s
  level: Level;
  node: string;
  text: string;
}

export interface Diagnostic {
  time: number; // s
  node: string;
  level: "ok" | "warning" | "error";
  text: string;
}

export interface StopState {
  stopped: boolean;
  source: string;
  reason: string;
  since: number; // s
}

/** Identity. */
export const kNoPose: Pose = { position: [0, 0, 0], rotation: [0, 0, 0, 1] };

/** What a place of a predicted surface rests on, and its colour. */
export const kOrigins = [
  { name: "seen", color: [0.3, 0.69, 0.31, 1] as Color },
  { name: "mirrored", color: [0.13, 0.59, 0.95, 1] as Color },
  { name: "touched", color: [1.0, 0.6, 0.0, 1] as Color },
  { name: "guessed", color: [0.62, 0.62, 0.62, 1] as Color },
] as const;
