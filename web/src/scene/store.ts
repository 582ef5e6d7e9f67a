/**
 * The state of the page: what came last of everything, bounded. Whoever changes a part says so by `touch`; whoever
 * shows it listens by `watch`, and is called at most once a picture however often it changed.
 */

import { Series } from "./series.js";
import type {
  Cloud,
  Diagnostic,
  Entity,
  FrameTransform,
  LogEntry,
  ObjectInfo,
  PadImage,
  PhaseMark,
  Picture,
  Plan,
  StopState,
  SurpriseMark,
  Vector,
} from "./types.js";

export type Part =
  | "entities"
  | "cloud"
  | "frames"
  | "objects"
  | "pads"
  | "pictures"
  | "signals"
  | "surprises"
  | "cycle"
  | "diagnostics"
  | "log"
  | "stop"
  | "clock"
  | "selection";

/** Of entities of objects and of grasps, where a server converts them. */
export const kObjectsTopic = "/viewer/objects";
export const kGraspsTopic = "/viewer/grasps";
/** Of entities that the page makes of plans itself. */
export const kRawPlansTopic = "raw plans";

const kMostLines = 500;
const kMostMarks = 400;
const kMostEntities = 5000;

export interface Selection {
  object: number | null;
  grasp: number | null; // rank
  /** m, world: where the object was clicked; absent: it was not. */
  at?: Vector;
}

export class Store {
  /** By topic, then id; those of one topic replace one another. */
  readonly entities = new Map<string, Map<string, Entity>>();
  readonly frames = new Map<string, FrameTransform>();
  cloud: Cloud | null = null;
  readonly objects = new Map<number, ObjectInfo>();
  readonly plans = new Map<number, Plan>();
  readonly pads = new Map<string, PadImage>();
  readonly pictures = new Map<string, Picture>();
  readonly series = new Map<string, Series>();
  surprises: SurpriseMark[] = [];
  phases: PhaseMark[] = [];
  result = "";
  taskStates: string[] = [];
  taskState = "";
  readonly diagnostics = new Map<string, Diagnostic>();
  log: LogEntry[] = [];
  stop: StopState | null = null;
  time = Number.NaN; // s, of the graph's or the recording's clock
  speed = Number.NaN; // of the simulated clock, 0: paused
  selection: Selection = { object: null, grasp: null };
  /** Stamp of the view that objects and plans are of. */
  view = 0n;

  readonly #watchers = new Map<Part, Set<() => void>>();
  readonly #touched = new Set<Part>();
  #scheduled = false;

  watch(parts: Part[], paint: () => void): void {
    for (const part of parts) {
      const watchers = this.#watchers.get(part) ?? new Set();
      watchers.add(paint);
      this.#watchers.set(part, watchers);
    }
  }

  touch(part: Part): void {
    this.#touched.add(part);
    if (this.#scheduled) return;
    this.#scheduled = true;
    requestAnimationFrame(() => this.flush());
  }

  /** Calls the watchers of what was touched, each once. */
  flush(): void {
    this.#scheduled = false;
    const paints = new Set<() => void>();
    for (const part of this.#touched) for (const paint of this.#watchers.get(part) ?? []) paints.add(paint);
    this.#touched.clear();
    for (const paint of paints) {
      try {
        paint();
      } catch (error) {
        console.error(error);
      }
    }
  }

  setEntity(topic: string, entity: Entity): void {
    const entities = this.entities.get(topic) ?? new Map<string, Entity>();
    this.entities.set(topic, entities);
    if (entities.size >= kMostEntities && !entities.has(entity.id)) return;
    entities.set(entity.id, entity);
    this.touch("entities");
  }

  /** Takes away the entity of that id; without one all of the topic. */
  deleteEntity(topic: string, id?: string): void {
    if (id === undefined) this.entities.delete(topic);
    else this.entities.get(topic)?.delete(id);
    this.touch("entities");
  }

  sample(name: string, time: number, value: number): void {
    let series = this.series.get(name);
    if (!series) {
      if (this.series.size >= 64) return;
      series = new Series();
      this.series.set(name, series);
    }
    series.add(time, value);
    this.touch("signals");
  }

  addLog(entry: LogEntry): void {
    if (
      this.log
        .slice(-100)
        .some((line) => line.time === entry.time && line.text === entry.text && line.node === entry.node)
    )
      return;
    this.log.push(entry);
    if (this.log.length > kMostLines) this.log = this.log.slice(-kMostLines / 2);
    this.touch("log");
  }

  addSurprise(mark: SurpriseMark): void {
    // A connection that comes back brings what is latched once more.
    if (this.surprises.some((other) => other.time === mark.time && other.name === mark.name)) return;
    this.surprises.push(mark);
    if (this.surprises.length > kMostMarks) this.surprises = this.surprises.slice(-kMostMarks / 2);
    this.touch("surprises");
  }

  addPhase(mark: PhaseMark): void {
    const last = this.phases.at(-1);
    if (last && mark.time < last.time) {
      // Latched, once more.
      if (this.phases.some((other) => other.time === mark.time && other.phase === mark.phase)) return;
      this.phases = this.phases.filter((other) => other.time <= mark.time); // time began anew
    }
    const again = last && last.phase === mark.phase && last.object === mark.object && last.grasp === mark.grasp;
    if (again) last.detail = mark.detail;
    else this.phases.push(mark);
    if (this.phases.length > kMostMarks) this.phases = this.phases.slice(-kMostMarks / 2);
    this.touch("cycle");
  }

  select(object: number | null, grasp: number | null = null, at?: Vector): void {
    this.selection = { object, grasp, ...(at && { at }) };
    this.touch("selection");
  }

  /** What is of a view begins anew when a later one comes. False: the message is of an earlier view. */
  beginView(stamp: bigint): boolean {
    if (stamp < this.view) return false;
    if (stamp > this.view) {
      this.view = stamp;
      if (!this.entities.has(kObjectsTopic)) this.objects.clear(); // else who sends them says when they go
      for (const plan of this.plans.values()) if (plan.stamp >= 0n) this.plans.delete(plan.object);
      for (const topic of this.entities.keys()) if (topic.startsWith("raw ")) this.entities.delete(topic);
      this.touch("entities");
      this.touch("objects");
    }
    return true;
  }

  /** Forgets everything: another session, another recording, another place in it. */
  reset(): void {
    this.entities.clear();
    this.frames.clear();
    this.cloud = null;
    this.objects.clear();
    this.plans.clear();
    this.pads.clear();
    this.pictures.clear();
    this.series.clear();
    this.surprises = [];
    this.phases = [];
    this.result = "";
    this.taskStates = [];
    this.taskState = "";
    this.diagnostics.clear();
    this.log = [];
    this.stop = null;
    this.time = Number.NaN;
    this.speed = Number.NaN;
    this.view = 0n;
    for (const part of this.#watchers.keys()) this.touch(part);
  }
}
