/** The cloud: colours are made on the graphics card, so that a change of colouring costs nothing here. */

import {
  BufferAttribute,
  BufferGeometry,
  DataTexture,
  Points,
  RGBAFormat,
  ShaderMaterial,
  UnsignedByteType,
  Vector2,
  Vector3,
  type Matrix4,
} from "three";
import type { Cloud } from "../scene/types.js";
import { kPalette, kRamp } from "./ramp.js";

export type CloudColoring = "depth" | "object" | "image";

const kModes: Record<CloudColoring, number> = { depth: 0, object: 1, image: 2 };

const kVertex = `
  attribute vec4 rgba;
  attribute float object;
  uniform int mode;
  uniform vec3 eye;
  uniform vec3 axis;
  uniform vec2 range;
  uniform float size;
  uniform sampler2D ramp;
  uniform vec3 palette[${kPalette.length}];
  varying vec3 shade;
  void main() {
    vec4 world = modelMatrix * vec4(position, 1.0);
    vec4 seen = viewMatrix * world;
    gl_Position = projectionMatrix * seen;
    gl_PointSize = clamp(size / -seen.z, 1.0, 8.0);
    if (mode == 0) {
      float share = (dot(world.xyz - eye, axis) - range.x) / max(range.y - range.x, 1e-6);
      shade = texture2D(ramp, vec2(clamp(share, 0.0, 1.0) * 0.996 + 0.002, 0.5)).rgb;
    } else if (mode == 1) {
      shade = object > 65534.5 ? vec3(0.55) : palette[int(mod(object + 0.5, ${kPalette.length}.0))];
    } else {
      shade = rgba.rgb;
    }
  }`;

const kFragment = `
  varying vec3 shade;
  void main() {
    vec2 from = gl_PointCoord - 0.5;
    if (dot(from, from) > 0.25) discard;
    gl_FragColor = vec4(shade, 1.0);
  }`;

export class CloudPoints {
  readonly points: Points<BufferGeometry, ShaderMaterial>;
  coloring: CloudColoring = "image";
  /** m, of the depths that the colours span. */
  readonly range = new Vector2(0, 1);
  /** Of a cloud of more points every second, third, ... is drawn. */
  mostDrawn = Infinity;
  #cloud: Cloud | null = null;
  readonly #eye = new Vector3();
  readonly #axis = new Vector3(0, 0, 1);

  constructor() {
    const ramp = new DataTexture(kRamp, 256, 1, RGBAFormat, UnsignedByteType);
    ramp.needsUpdate = true;
    const material = new ShaderMaterial({
      vertexShader: kVertex,
      fragmentShader: kFragment,
      uniforms: {
        mode: { value: 1 },
        eye: { value: this.#eye },
        axis: { value: this.#axis },
        range: { value: this.range },
        size: { value: 3 },
        ramp: { value: ramp },
        palette: { value: kPalette.map((color) => new Vector3(...color)) },
      },
    });
    this.points = new Points(new BufferGeometry(), material);
    this.points.frustumCulled = false; // its bounds would be computed anew for every cloud
    this.points.matrixAutoUpdate = false;
  }

  /** `size`: pixels of a point at 1 m. */
  setPointSize(size: number): void {
    this.points.material.uniforms["size"]!.value = size;
  }

  /** What can be shown of what was asked for: a cloud without colours of its own is shown by object. */
  get effective(): CloudColoring {
    if (this.coloring === "image" && !this.#cloud?.colors) return this.#cloud?.objects ? "object" : "depth";
    if (this.coloring === "object" && !this.#cloud?.objects) return this.#cloud?.colors ? "image" : "depth";
    return this.coloring;
  }

  show(cloud: Cloud | null): void {
    if (cloud !== this.#cloud) {
      this.#cloud = cloud;
      const geometry = this.points.geometry;
      const set = (
        name: string,
        array: Float32Array | Uint8Array | Uint16Array,
        size: number,
        normalized: boolean,
      ): void => {
        const old = geometry.getAttribute(name) as BufferAttribute | undefined;
        if (old && old.array.length === array.length && old.array.constructor === array.constructor) {
          old.array = array; // the buffer on the card is filled again instead of made anew
          old.needsUpdate = true;
        } else {
          geometry.setAttribute(name, new BufferAttribute(array, size, normalized));
        }
      };
      const count = cloud?.count ?? 0;
      set("position", cloud?.positions ?? new Float32Array(), 3, false);
      set("rgba", cloud?.colors ?? new Uint8Array(4 * count), 4, true);
      set("object", cloud?.objects ?? new Uint16Array(count), 1, false);
      this.#thin(count);
    }
    this.points.material.uniforms["mode"]!.value = kModes[this.effective];
  }

  /** Every how many-th point is drawn. */
  get every(): number {
    return Math.max(1, Math.ceil((this.#cloud?.count ?? 0) / this.mostDrawn));
  }

  #thin(count: number): void {
    const { geometry } = this.points;
    const { every } = this;
    const drawn = Math.ceil(count / every);
    if (every === 1) geometry.setIndex(null);
    else if (geometry.index?.count !== drawn || geometry.index.getX(1) !== every) {
      geometry.setIndex(
        new BufferAttribute(
          Uint32Array.from({ length: drawn }, (_, i) => i * every),
          1,
        ),
      );
    }
    geometry.setDrawRange(0, drawn);
  }

  /** Depth is along the camera's axis, or upward where no camera is known. `world`: pose of the cloud's frame. */
  setCamera(camera: Matrix4 | null, world: Matrix4): void {
    this.points.matrix.copy(world);
    this.points.matrixWorldNeedsUpdate = true;
    if (camera) {
      this.#eye.setFromMatrixPosition(camera);
      this.#axis.setFromMatrixColumn(camera, 2).normalize();
    } else {
      this.#eye.set(0, 0, 0);
      this.#axis.set(0, 0, 1);
    }
    const positions = this.#cloud?.positions;
    if (!positions || this.effective !== "depth") return;
    const m = world.elements;
    const a = this.#axis;
    // dot(axis, world p - eye) as one linear function of p.
    const ax = a.x * m[0] + a.y * m[1] + a.z * m[2];
    const ay = a.x * m[4] + a.y * m[5] + a.z * m[6];
    const az = a.x * m[8] + a.y * m[9] + a.z * m[10];
    const offset = a.x * (m[12] - this.#eye.x) + a.y * (m[13] - this.#eye.y) + a.z * (m[14] - this.#eye.z);
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i + 2 < positions.length; i += 3) {
      const depth = ax * positions[i]! + ay * positions[i + 1]! + az * positions[i + 2]! + offset;
      if (depth < low) low = depth;
      if (depth > high) high = depth;
    }
    if (low <= high) this.range.set(low, high);
  }
}
