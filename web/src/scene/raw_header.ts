/** What the graph's own messages have in common, and entities made of them. */

import { child, integer64, text, type Fields } from "../protobuf/fields.js";
import type { Entity, Primitive } from "./types.js";

/** Stamp [ns] of the view and frame of a message; the world where it names none. */
export function header(fields: Fields): { stamp: bigint; frame: string } {
  const from = child(fields, "header");
  return { stamp: integer64(from, "stamp"), frame: text(from, "frameId") || "world" };
}

/** In the world, with nothing said of it. */
export function entity(id: string, primitives: Primitive[]): Entity {
  return { id, frame: "world", primitives, metadata: new Map() };
}
