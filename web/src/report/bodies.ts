/** The scene of a report, out of its JSON (prehend/report/scene.h). */

import { BufferAttribute, BufferGeometry, Color, DoubleSide, Group, Mesh, MeshStandardMaterial } from "three";

const kNumbersOfPose = 7; // position, then quaternion, w first

interface BodyData {
  name: string;
  color: string;
  opacity: number;
  vertices: string; // base64 of float32, m
  triangles: string; // base64 of uint32
  poses: string; // base64 of float32: one for each frame, or one for all
}

export interface SceneData {
  times: number[]; // s, of the frames
  captions: string[]; // of the frames
  bodies: BodyData[];
}

function bytesOf(base64: string): ArrayBuffer {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes.buffer;
}

function meshOf(data: BodyData): Mesh {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(bytesOf(data.vertices)), 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(bytesOf(data.triangles)), 1));
  const material = new MeshStandardMaterial({
    color: new Color(data.color),
    flatShading: true,
    side: DoubleSide,
    transparent: data.opacity < 1,
    opacity: data.opacity,
    depthWrite: data.opacity === 1,
  });
  const mesh = new Mesh(geometry, material);
  mesh.matrixAutoUpdate = true;
  return mesh;
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
      const mesh = meshOf(body);
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
