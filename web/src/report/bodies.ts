/** The scene of a report, out of its JSON (prehend/report/film.h). */

import { Group, type Mesh } from "three";
import { bytesOf, geometryOf, type LookData, type MeshData, meshOf } from "./mesh.js";

const kNumbersOfPose = 7; // position, then quaternion, w first

interface BodyData extends MeshData, LookData {
  name: string;
  poses: string; // base64 of float32: one for each frame, or one for all
}

export interface SceneData {
  times: number[]; // s, of the frames
  captions: string[]; // of the frames
  bodies: BodyData[];
}

/** All bodies of a scene, by the names that are shown and hidden together. */
export class Bodies {
  readonly root = new Group();
  readonly named = new Map<string, Group>();
  readonly #moving: { mesh: Mesh; poses: Float32Array }[] = [];

  constructor(data: SceneData) {
    for (const body of data.bodies) {
      let group = this.named.get(body.name);
      if (!group) {
        group = new Group();
        this.named.set(body.name, group);
        this.root.add(group);
      }
      const mesh = meshOf(geometryOf(body), body);
      group.add(mesh);
      this.#moving.push({ mesh, poses: new Float32Array(bytesOf(body.poses)) });
    }
    this.show(0);
  }

  /** As they stood in a frame. */
  show(frame: number): void {
    for (const { mesh, poses } of this.#moving) {
      const at = kNumbersOfPose * Math.min(frame, poses.length / kNumbersOfPose - 1);
      const [x, y, z, qw, qx, qy, qz] = poses.subarray(at, at + kNumbersOfPose);
      mesh.position.set(x!, y!, z!);
      mesh.quaternion.set(qx!, qy!, qz!, qw!);
    }
  }
}
