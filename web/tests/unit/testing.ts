// What the page's modules need of a browser, and a store that takes messages as a live channel's.

import { Ingest, type Source } from "../../src/scene/ingest.js";
import { Store } from "../../src/scene/store.js";
// @ts-expect-error: plain JavaScript, shared with the browser's tests
import { encode as encodeAny, schemaOf as schemaOfAny } from "../schemas.mjs";

export const encode = encodeAny as (name: string, value: object) => Uint8Array;
export const schemaOf = schemaOfAny as (name: string) => Uint8Array;

globalThis.requestAnimationFrame ??= (callback) =>
  setTimeout(() => callback(performance.now()), 1) as unknown as number;

export class Taken {
  readonly store = new Store();
  readonly ingest = new Ingest(this.store);
  readonly troubles: string[] = [];

  constructor() {
    this.ingest.onTrouble = (text) => this.troubles.push(text);
  }

  take(topic: string, schemaName: string, message: object | Uint8Array, time = 0n): this {
    const data = message instanceof Uint8Array ? message : encode(schemaName, message);
    const source: Source = { topic, schemaName, encoding: "protobuf" };
    this.ingest.take(`${topic} ${schemaName}`, source, () => schemaOf(schemaName), time, data);
    return this;
  }
}
