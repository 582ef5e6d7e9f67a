/** Frames by their parents -> poses in the fixed frame. */

import { Matrix4, Quaternion, Vector3 } from "three";
import type { FrameTransform, Pose } from "../scene/types.js";

const kDeepest = 64; // of a chain of frames; a longer one is a circle

export function matrixOf(pose: Pose, into = new Matrix4()): Matrix4 {
  return into.compose(new Vector3(...pose.position), new Quaternion(...pose.rotation), new Vector3(1, 1, 1));
}

export class FrameTree {
  readonly #world = new Map<string, Matrix4 | null>();

  constructor(private readonly frames: ReadonlyMap<string, FrameTransform>) {}

  /** What was found is found anew from now on. */
  refresh(): void {
    this.#world.clear();
  }

  /** Pose of the frame in the fixed one, which is whatever has no parent; null: its parents are a circle. */
  world(name: string, depth = 0): Matrix4 | null {
    const known = this.#world.get(name);
    if (known !== undefined) return known;
    let result: Matrix4 | null = null;
    const frame = this.frames.get(name);
    if (!frame) {
      result = new Matrix4();
    } else if (depth < kDeepest) {
      const parent = this.world(frame.parent, depth + 1);
      if (parent) result = matrixOf(frame.pose).premultiply(parent);
    }
    this.#world.set(name, result);
    return result;
  }
}
