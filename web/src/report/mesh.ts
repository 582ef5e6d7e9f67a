/** Triangles, and what they look like. */

import { BufferAttribute, BufferGeometry, Color, DoubleSide, Mesh, MeshStandardMaterial } from "three";

export interface MeshData {
  vertices: string; // base64 of float32, m
  triangles: string; // base64 of uint32
}

export interface LookData {
  color: string;
  opacity: number;
}

export function bytesOf(base64: string): ArrayBuffer {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes.buffer;
}

export function geometryOf(data: MeshData): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(bytesOf(data.vertices)), 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(bytesOf(data.triangles)), 1));
  return geometry;
}

export function meshOf(geometry: BufferGeometry, look: LookData): Mesh<BufferGeometry, MeshStandardMaterial> {
  const material = new MeshStandardMaterial({
    color: new Color(look.color),
    flatShading: true,
    side: DoubleSide,
    transparent: look.opacity < 1,
    opacity: look.opacity,
    depthWrite: look.opacity === 1,
  });
  return new Mesh(geometry, material);
}
