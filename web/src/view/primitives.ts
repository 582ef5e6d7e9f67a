/** Primitives of entities -> three.js objects. */

import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  Color as ThreeColor,
  CylinderGeometry,
  DoubleSide,
  Group,
  Line,
  LineBasicMaterial,
  LineLoop,
  LineSegments,
  Matrix4,
  Mesh as ThreeMesh,
  MeshLambertMaterial,
  SphereGeometry,
  Sprite,
  SRGBColorSpace,
  type Object3D,
} from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import type { Color, Mesh, Primitive } from "../scene/types.js";
import { simplified } from "./simplify.js";
import { label } from "./label.js";
import { matrixOf } from "./frame_tree.js";

/** Bytes of sRGB -> of linear light, in which three.js computes. */
const kLinear = Uint8Array.from({ length: 256 }, (_, i) => {
  const value = i / 255;
  return Math.round(255 * (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
});

function material(color: Color | null, options: { flat?: boolean; vertexColors?: boolean } = {}): MeshLambertMaterial {
  const alpha = color?.[3] ?? 1;
  return new MeshLambertMaterial({
    color: color ? new ThreeColor().setRGB(color[0], color[1], color[2], SRGBColorSpace) : 0xffffff,
    transparent: alpha < 1,
    opacity: alpha,
    depthWrite: alpha > 0.5,
    side: DoubleSide,
    flatShading: options.flat ?? false,
    vertexColors: options.vertexColors ?? false,
  });
}

function meshObject(given: Mesh, color: Color, flat: boolean): Object3D {
  const mesh = simplified(given);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(mesh.positions, 3));
  if (mesh.indices) geometry.setIndex(new BufferAttribute(mesh.indices, 1));
  if (mesh.colors) {
    geometry.setAttribute(
      "color",
      new BufferAttribute(
        mesh.colors.map((byte, i) => (i % 4 === 3 ? byte : kLinear[byte]!)),
        4,
        true,
      ),
    );
  }
  if (!flat) geometry.computeVertexNormals();
  return new ThreeMesh(geometry, material(mesh.colors ? null : color, { flat, vertexColors: mesh.colors !== null }));
}

function arrow(primitive: Extract<Primitive, { kind: "arrow" }>): Object3D {
  const group = new Group();
  const paint = material(primitive.color);
  const { shaftLength, shaftDiameter, headLength, headDiameter } = primitive;
  const shaft = new ThreeMesh(new CylinderGeometry(shaftDiameter / 2, shaftDiameter / 2, shaftLength, 12), paint);
  shaft.rotation.z = -Math.PI / 2; // three's cylinders stand along y, the arrow along x
  shaft.position.x = shaftLength / 2;
  const head = new ThreeMesh(new CylinderGeometry(0, headDiameter / 2, headLength, 16), paint);
  head.rotation.z = -Math.PI / 2;
  head.position.x = shaftLength + headLength / 2;
  group.add(shaft, head);
  return group;
}

function line(primitive: Extract<Primitive, { kind: "line" }>): Object3D {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(primitive.points, 3));
  const [red, green, blue, alpha] = primitive.color;
  const paint = new LineBasicMaterial({
    color: new ThreeColor().setRGB(red, green, blue, SRGBColorSpace),
    transparent: alpha < 1,
    opacity: alpha,
  });
  if (primitive.shape === "list") return new LineSegments(geometry, paint);
  return primitive.shape === "loop" ? new LineLoop(geometry, paint) : new Line(geometry, paint);
}

/** `loaded` is called when a model that takes its time is there. */
function model(primitive: Extract<Primitive, { kind: "model" }>, loaded: () => void): Object3D {
  const group = new Group();
  group.scale.set(...primitive.scale);
  const data = primitive.data.slice().buffer;
  const add = (object: Object3D): void => {
    if (primitive.color) {
      const paint = material(primitive.color, { flat: true });
      object.traverse((part) => {
        if (part instanceof ThreeMesh) part.material = paint;
      });
    }
    group.add(object);
    loaded();
  };
  switch (primitive.mediaType) {
    case "model/stl":
      add(new ThreeMesh(new STLLoader().parse(data), material([0.7, 0.7, 0.72, 1], { flat: true })));
      break;
    case "model/obj":
      add(new OBJLoader().parse(new TextDecoder().decode(data)));
      break;
    case "model/gltf-binary":
    case "model/gltf+json": {
      const turned = new Group();
      turned.rotation.x = Math.PI / 2; // glTF's y is up
      new GLTFLoader().parse(
        data,
        "",
        (gltf) => {
          turned.add(gltf.scene);
          add(turned);
        },
        (error) => console.error(error),
      );
      break;
    }
    default:
      throw new Error(`a model of type "${primitive.mediaType}" is not shown`);
  }
  return group;
}

function shape(primitive: Primitive, flat: boolean, loaded: () => void): Object3D {
  switch (primitive.kind) {
    case "mesh":
      return meshObject(primitive.mesh, primitive.color, flat);
    case "arrow":
      return arrow(primitive);
    case "cube":
      return new ThreeMesh(new BoxGeometry(...primitive.size), material(primitive.color));
    case "sphere": {
      const sphere = new ThreeMesh(new SphereGeometry(0.5, 20, 14), material(primitive.color));
      sphere.scale.set(...primitive.size);
      return sphere;
    }
    case "cylinder": {
      const geometry = new CylinderGeometry(0.5 * primitive.topScale, 0.5 * primitive.bottomScale, 1, 24);
      geometry.rotateX(Math.PI / 2); // its axis is z
      geometry.scale(...primitive.size);
      return new ThreeMesh(geometry, material(primitive.color));
    }
    case "line":
      return line(primitive);
    case "text":
      return label(primitive.text, primitive.size, primitive.isScaleInvariant, primitive.color);
    case "model":
      return model(primitive, loaded);
  }
}

/** `flat`: faces keep their edges, as those of machines; else surfaces are smooth. */
export function primitiveObject(primitive: Primitive, flat: boolean, loaded: () => void): Object3D {
  const holder = new Group();
  holder.matrixAutoUpdate = false;
  matrixOf(primitive.pose, holder.matrix);
  holder.add(shape(primitive, flat, loaded));
  return holder;
}

/** Frees what the object holds on the graphics card. */
export function dispose(object: Object3D): void {
  object.traverse((part) => {
    if (part instanceof Sprite) {
      part.material.map?.dispose();
      part.material.dispose();
    }
    if (!(part instanceof ThreeMesh || part instanceof Line)) return;
    (part.geometry as BufferGeometry).dispose();
    for (const paint of Array.isArray(part.material) ? part.material : [part.material]) paint.dispose();
  });
}

export const kIdentity = new Matrix4();
