/** What every panel may use: the state, the server, and how to say something to whoever looks. */

import type { Connection } from "./protocol/connection.js";
import type { Store } from "./scene/store.js";

export type Tone = "info" | "warning" | "error";

export interface App {
  readonly store: Store;
  readonly connection: Connection;
  /** Says it in the corner of the page; a later one of the same id replaces it. */
  say(text: string, tone?: Tone, id?: string): void;
  /** True while a recording is shown instead of the graph. */
  isRecording(): boolean;
  /** Empty: the service can be called; else why not, in words. */
  whyNot(service: string): string;
  /** Calls a JSON service and says what came of it. True: it was done. */
  request(service: string, body: unknown): Promise<boolean>;
}
