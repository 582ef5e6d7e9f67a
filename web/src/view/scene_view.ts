/** The store's entities, cloud and frames as a three.js scene: only what changed is built anew. */

import { Box3, Group, Mesh, MeshLambertMaterial, Scene, type Matrix4, type Object3D } from "three";
import type { Store } from "../scene/store.js";
import type { Entity } from "../scene/types.js";
import { CloudPoints } from "./cloud_points.js";
import { FrameTree } from "./frame_tree.js";
import { dispose, kIdentity, primitiveObject } from "./primitives.js";

export type Layer = "cloud" | "shapes" | "alternatives" | "grasps" | "robot" | "table" | "truth";
export type GraspChoice = "best" | "selected" | "all";

interface Shown {
  entity: Entity;
  root: Group;
  layer: Layer;
}

export function layerOf(id: string): Layer {
  if (/^object\/\d+\/alternative/.test(id)) return "alternatives";
  if (id.startsWith("object/")) return "shapes";
  if (id.startsWith("grasp/")) return "grasps";
  if (id.startsWith("truth/")) return "truth";
  if (id.startsWith("robot/") || id.startsWith("hand/")) return "robot";
  return id.startsWith("table") ? "table" : "robot";
}

export class SceneView {
  readonly scene = new Scene();
  readonly cloud = new CloudPoints();
  readonly visible: Record<Layer, boolean> = {
    cloud: true,
    shapes: true,
    alternatives: false,
    grasps: true,
    robot: true,
    table: true,
    truth: false,
  };
  graspChoice: GraspChoice = "selected";
  /** Where entities' ids of the layers that can be clicked are. */
  readonly pickable = new Group();
  onTrouble: (text: string) => void = () => {};

  readonly #others = new Group();
  readonly #shown = new Map<string, Shown>();
  readonly #tree: FrameTree;
  #places = ""; // of the camera and the cloud

  constructor(
    private readonly store: Store,
    private readonly invalidate: () => void,
  ) {
    this.#tree = new FrameTree(store.frames);
    this.scene.add(this.pickable, this.#others, this.cloud.points);
    store.watch(["entities"], () => this.#takeEntities());
    store.watch(["frames"], () => this.#takeFrames());
    store.watch(["cloud"], () => this.takeCloud());
    store.watch(["selection", "objects"], () => this.applyVisibility());
  }

  takeCloud(): void {
    const { cloud } = this.store;
    this.cloud.show(cloud);
    const [camera, world] = this.#cloudPlaces();
    this.cloud.setCamera(camera, world);
    this.invalidate();
  }

  /** Where the camera is, if that is known, and the cloud's frame. */
  #cloudPlaces(): [camera: Matrix4 | null, world: Matrix4] {
    const { cloud, frames } = this.store;
    const name = frames.has("camera") ? "camera" : [...frames.keys()].find((other) => other.startsWith("camera"));
    return [name === undefined ? null : this.#tree.world(name), (cloud && this.#tree.world(cloud.frame)) ?? kIdentity];
  }

  applyVisibility(): void {
    const { object, grasp } = this.store.selection;
    for (const { entity, root, layer } of this.#shown.values()) {
      let visible = this.visible[layer];
      const parts = entity.id.split("/");
      const isSelected = parts[1] === String(object);
      if (layer === "grasps") {
        const chosen = isSelected && (grasp === null ? parts[2] === "0" : parts[2] === String(grasp));
        if (this.graspChoice === "best") visible &&= parts[2] === "0" || chosen;
        else if (this.graspChoice === "selected")
          visible &&= object === null ? parts[2] === "0" : isSelected && (grasp === null || chosen);
        // Of the chosen object's grasps the one that would be executed stands out.
        highlight(root, chosen ? 0.2 : 0, isSelected && !chosen ? 0.22 : 1);
      } else if (layer === "shapes") {
        highlight(root, isSelected ? 0.05 : 0);
      }
      root.visible = visible;
    }
    this.cloud.points.visible = this.visible.cloud;
    this.invalidate();
  }

  /** Bounds of what matters: objects and grasps, else all; null: there is nothing. */
  bounds(): Box3 | null {
    this.scene.updateMatrixWorld();
    const box = new Box3();
    for (const layers of [["shapes"], ["table", "robot", "grasps"]]) {
      for (const { root, layer } of this.#shown.values()) if (layers.includes(layer)) box.expandByObject(root);
      if (!box.isEmpty()) return box;
    }
    if (this.store.cloud && this.store.cloud.count > 0) {
      this.cloud.points.geometry.computeBoundingBox();
      const own = this.cloud.points.geometry.boundingBox;
      if (own) return own.clone().applyMatrix4(this.cloud.points.matrix);
    }
    return null;
  }

  hasShapes(): boolean {
    return [...this.#shown.values()].some(({ layer }) => layer === "shapes");
  }

  /** The id of the entity that `object` is a part of. */
  idOf(object: Object3D): string | null {
    for (let at: Object3D | null = object; at; at = at.parent) {
      if (typeof at.userData["id"] === "string") return at.userData["id"];
    }
    return null;
  }

  #takeEntities(): void {
    const present = new Set<string>();
    for (const [topic, entities] of this.store.entities) {
      for (const [id, entity] of entities) {
        const key = `${topic} ${id}`;
        present.add(key);
        if (this.#shown.get(key)?.entity !== entity) this.#build(key, entity);
      }
    }
    for (const key of [...this.#shown.keys()]) if (!present.has(key)) this.#remove(key);
    this.#takeFrames();
    this.applyVisibility();
  }

  #takeFrames(): void {
    this.#tree.refresh();
    for (const { entity, root } of this.#shown.values()) this.#place(entity, root);
    const places = this.#cloudPlaces();
    const moved = places.map((place) => place?.elements.join()).join(";");
    if (moved !== this.#places) {
      this.#places = moved;
      this.takeCloud();
    }
    this.invalidate();
  }

  #place(entity: Entity, root: Group): void {
    const world = this.#tree.world(entity.frame);
    if (world) root.matrix.copy(world);
    root.matrixWorldNeedsUpdate = true;
  }

  #build(key: string, entity: Entity): void {
    this.#remove(key);
    const root = new Group();
    root.matrixAutoUpdate = false;
    root.userData["id"] = entity.id;
    const layer = layerOf(entity.id);
    for (const primitive of entity.primitives) {
      try {
        root.add(primitiveObject(primitive, layer === "robot" || layer === "table", this.invalidate));
      } catch (error) {
        this.onTrouble(`${entity.id}: ${error instanceof Error ? error.message : String(error)}`);
      }
    }
    this.#shown.set(key, { entity, root, layer });
    (layer === "shapes" || layer === "grasps" ? this.pickable : this.#others).add(root);
  }

  #remove(key: string): void {
    const shown = this.#shown.get(key);
    if (!shown) return;
    shown.root.removeFromParent();
    dispose(shown.root);
    this.#shown.delete(key);
  }
}

/** Lets it glow, and shine through: `share` of the opacity that it has. */
function highlight(root: Object3D, strength: number, share = 1): void {
  root.traverse((part) => {
    if (!(part instanceof Mesh) || !(part.material instanceof MeshLambertMaterial)) return;
    const own = (part.material.userData["opacity"] ??= part.material.opacity) as number;
    part.material.opacity = own * share;
    part.material.transparent = own * share < 1;
    part.material.depthWrite = own * share > 0.5;
    part.material.emissive.copy(part.material.color).multiplyScalar(strength);
  });
}
