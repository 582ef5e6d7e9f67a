/** A robot out of its JSON (prehend/report/robot_figure.h): links that stand where their joints put them. */

import { ArrowHelper, Group, Matrix4, type Mesh, Quaternion, Vector3 } from "three";
import { geometryOf, type LookData, type MeshData, meshOf } from "./mesh.js";

type Pose = [number, number, number, number, number, number, number]; // position m, quaternion, w first

export interface JointData {
  name: string;
  kind: "fixed" | "revolute" | "prismatic" | "other"; // other: stands at 0
  parent: number; // links
  child: number;
  pose: Pose; // of the joint in the parent
  child_pose: Pose; // of the child in the joint at 0
  axis: [number, number, number];
  lower: number | null; // rad or m; null: none
  upper: number | null;
  start: number; // rad or m
  leader: number | null; // the joint that it follows
  coefficients: number[]; // of the polynomial of that one's position that it follows by, from the constant on
  words: string;
}

interface ShapeData extends LookData {
  link: number;
  layer: string;
  mesh: number;
  pose: Pose; // in the link
}

export interface RobotData {
  links: { name: string; words: string }[];
  joints: JointData[];
  meshes: MeshData[];
  shapes: ShapeData[];
  postures: { name: string; positions: [number, number][] }[]; // joint, rad or m
}

function matrixOf(pose: Pose): Matrix4 {
  const [x, y, z, qw, qx, qy, qz] = pose;
  return new Matrix4().compose(new Vector3(x, y, z), new Quaternion(qx, qy, qz, qw), new Vector3(1, 1, 1));
}

/** Without a limit a turn to either side, or half a metre, can be shown. */
export function rangeOf(joint: JointData): [number, number] {
  const otherwise = joint.kind === "prismatic" ? 0.5 : Math.PI;
  return [joint.lower ?? -otherwise, joint.upper ?? otherwise];
}

export class RobotBody {
  readonly root = new Group();
  readonly links: Group[];
  readonly layers = new Map<string, Mesh[]>();
  readonly axes: ArrowHelper[] = [];
  readonly positions: number[]; // rad or m
  readonly #linkOf = new Map<unknown, number>();

  constructor(private readonly data: RobotData) {
    this.links = data.links.map(() => new Group());
    const hung = new Set<number>();
    for (const { parent, child } of data.joints) {
      this.links[parent]!.add(this.links[child]!);
      hung.add(child);
    }
    this.links.forEach((link, i) => {
      link.matrixAutoUpdate = false;
      if (!hung.has(i)) this.root.add(link);
    });
    const geometries = data.meshes.map(geometryOf);
    for (const shape of data.shapes) {
      const mesh = meshOf(geometries[shape.mesh]!, shape);
      matrixOf(shape.pose).decompose(mesh.position, mesh.quaternion, mesh.scale);
      this.links[shape.link]!.add(mesh);
      this.#linkOf.set(mesh, shape.link);
      const layer = this.layers.get(shape.layer);
      if (layer) layer.push(mesh);
      else this.layers.set(shape.layer, [mesh]);
    }
    this.positions = data.joints.map((joint) => joint.start);
    this.move();
  }

  /** Arrows along the axes of joints that move, `length` m long. */
  drawAxes(length: number): void {
    for (const joint of this.data.joints) {
      if (joint.kind !== "revolute" && joint.kind !== "prismatic") continue;
      const pose = matrixOf(joint.pose);
      const arrow = new ArrowHelper(
        new Vector3(...joint.axis).transformDirection(pose),
        new Vector3().setFromMatrixPosition(pose),
        length,
        joint.kind === "revolute" ? 0xd02020 : 0x2060d0,
      );
      this.links[joint.parent]!.add(arrow);
      this.axes.push(arrow);
    }
  }

  /** Links where `positions` put them, after those that follow have followed. */
  move(): void {
    this.data.joints.forEach((joint, i) => {
      if (joint.leader !== null) this.positions[i] = this.#followed(i, this.data.joints.length);
    });
    this.data.joints.forEach((joint, i) => {
      const motion = new Matrix4();
      const axis = new Vector3(...joint.axis);
      if (joint.kind === "revolute") motion.makeRotationAxis(axis, this.positions[i]!);
      if (joint.kind === "prismatic") motion.setPosition(axis.multiplyScalar(this.positions[i]!));
      const link = this.links[joint.child]!;
      link.matrix.copy(matrixOf(joint.pose).multiply(motion).multiply(matrixOf(joint.child_pose)));
      link.matrixWorldNeedsUpdate = true;
    });
  }

  /** `most` bounds chains of joints that follow one another in a ring. */
  #followed(i: number, most: number): number {
    const { leader, coefficients } = this.data.joints[i]!;
    if (leader === null || most <= 0) return this.positions[i]!;
    const q = this.#followed(leader, most - 1);
    return coefficients.reduceRight((sum, c) => sum * q + c, 0);
  }

  /** The link that a body belongs to; null: to none. */
  linkOf(body: unknown): number | null {
    return this.#linkOf.get(body) ?? null;
  }

  /** Lets the shapes of one link shine, and no others; null: none. */
  mark(link: number | null): void {
    for (const meshes of this.layers.values()) {
      for (const mesh of meshes) {
        const { material } = mesh as ReturnType<typeof meshOf>;
        material.emissive.setHex(this.#linkOf.get(mesh) === link ? 0xb05000 : 0);
      }
    }
  }
}
