/** How a message type gets into the store; one table of these for each family of types. */

import type { Fields } from "../protobuf/fields.js";
import type { TriangleList } from "../protobuf/triangle_lists.js";
import type { Store } from "./store.js";

export interface Arrival {
  topic: string;
  time: number; // s, when it was published
  fields: Fields;
  /** Of foxglove.SceneUpdate: the vertices of its triangle lists, by entity; `fields` has them without. */
  lists?: TriangleList[][];
}

/** Throws an Error in words on what cannot be shown. */
export type Handler = (store: Store, arrival: Arrival) => void;

export type Handlers = Readonly<Record<string, Handler>>;
