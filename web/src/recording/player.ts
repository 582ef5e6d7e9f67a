/** Plays a recording into the store: at a speed, paused, from any moment. */

import { Signal } from "../events.js";
import { isShown, kindOf, type Ingest, type Kind } from "../scene/ingest.js";
import { kSpan } from "../scene/series.js";
import type { Store } from "../scene/store.js";
import { seconds } from "../time.js";
import type { RecordedMessage, Recording } from "./recording.js";

const kMostBehind = 0.25; // s of recorded time a picture: a page that was hidden goes on from where it was
const kMostState = 256e6; // bytes that are kept of them
const kTurn = 12; // ms of reading, after which the page is drawn

export class Player {
  readonly changed = new Signal<[]>();
  readonly trouble = new Signal<[string]>();
  playing = false;
  speed = 1;

  #at: bigint;
  #messages: AsyncIterator<RecordedMessage> | null = null;
  #next: RecordedMessage | null = null;
  #advancing: Promise<void> = Promise.resolve();
  #seeking: Promise<void> | null = null;
  #goal: bigint | null = null; // where to go next
  /** Messages of state up to #stateEnd, so that they are read and unpacked once. */
  readonly #state: RecordedMessage[] = [];
  #stateEnd: bigint;
  #stateBytes = 0;
  #closed = false;
  #lastTick = 0;
  readonly #topics: Record<Kind, string[]> = { state: [], signal: [], latest: [] };

  constructor(
    readonly name: string,
    readonly recording: Recording,
    private readonly store: Store,
    private readonly ingest: Ingest,
  ) {
    this.#at = recording.start;
    this.#stateEnd = recording.start - 1n;
    const all = [...recording.channels.values()];
    for (const channel of all) {
      if (isShown(channel, all)) this.#topics[kindOf(channel.schemaName)].push(channel.topic);
    }
  }

  /** s, from the beginning. */
  get position(): number {
    return seconds(this.#at - this.recording.start);
  }

  get duration(): number {
    return seconds(this.recording.end - this.recording.start);
  }

  /** Number of topics of which something is shown. */
  get topicCount(): number {
    return Object.values(this.#topics).reduce((sum, topics) => sum + topics.length, 0);
  }

  play(playing: boolean): void {
    if (playing && this.#at >= this.recording.end) void this.seek(0);
    this.playing = playing;
    this.#lastTick = performance.now();
    this.changed.emit();
    if (playing) requestAnimationFrame((now) => void this.#tick(now));
  }

  close(): void {
    this.#closed = true;
    this.playing = false;
  }

  /**
   * Shows the moment `position` [s from the beginning]: state as it was, signals of the time a chart is wide. Ends
   * when it is shown, or another that was asked for meanwhile.
   */
  seek(position: number): Promise<void> {
    const { start, end } = this.recording;
    const offset = BigInt(Math.round(Math.max(0, Math.min(position, this.duration)) * 1e9));
    this.#goal = start + offset < end ? start + offset : end;
    this.#seeking ??= this.#seekAll();
    return this.#seeking;
  }

  async #seekAll(): Promise<void> {
    try {
      await this.#advancing;
      while (this.#goal !== null && !this.#closed) {
        const goal: bigint = this.#goal;
        this.#goal = null;
        await this.#show(goal);
      }
    } catch (error) {
      this.#fail(error);
    } finally {
      this.#seeking = null;
    }
    this.changed.emit();
  }

  async #show(goal: bigint): Promise<void> {
    const { recording } = this;
    const stopped = (): boolean => this.#goal !== null || this.#closed;
    const messages = await this.#stateUntil(goal, stopped);
    if (!messages) return;
    for (const topic of this.#topics.latest) {
      for await (const message of recording.messages({
        topics: [topic],
        from: recording.start,
        to: goal,
        reverse: true,
      })) {
        messages.push(message);
        break;
      }
      if (stopped()) return;
    }
    const early = goal - BigInt(kSpan) * 1_000_000_000n;
    const from = early > recording.start ? early : recording.start;
    for await (const message of recording.messages({ topics: this.#topics.signal, from, to: goal })) {
      messages.push(message);
      if (stopped()) return;
    }
    messages.sort((a, b) => (a.time < b.time ? -1 : a.time > b.time ? 1 : 0));
    this.store.reset();
    for (const message of messages) this.#take(message);
    this.#at = goal;
    this.store.time = seconds(goal);
    this.store.touch("clock");
    await this.#messages?.return?.();
    this.#next = null;
    this.#messages = recording
      .messages({ topics: Object.values(this.#topics).flat(), from: goal + 1n, to: recording.end })
      [Symbol.asyncIterator]();
  }

  /** Null: it was stopped before all were read. */
  async #stateUntil(goal: bigint, stopped: () => boolean): Promise<RecordedMessage[] | null> {
    const { recording } = this;
    const topics = this.#topics.state;
    if (goal > this.#stateEnd && this.#stateBytes < kMostState) {
      const fresh: RecordedMessage[] = [];
      for await (const message of recording.messages({ topics, from: this.#stateEnd + 1n, to: goal })) {
        fresh.push({ ...message, data: message.data.slice() }); // a view would keep all of its chunk
        if (stopped()) return null;
      }
      for (const message of fresh) {
        this.#state.push(message);
        this.#stateBytes += message.data.length;
      }
      this.#stateEnd = goal;
    }
    const messages = this.#state.filter(({ time }) => time <= goal);
    if (goal > this.#stateEnd) {
      for await (const message of recording.messages({ topics, from: this.#stateEnd + 1n, to: goal })) {
        messages.push(message);
        if (stopped()) return null;
      }
    }
    return messages;
  }

  async #tick(now: number): Promise<void> {
    if (!this.playing || this.#closed) return;
    const passed = Math.min(Math.max(0, now - this.#lastTick) / 1000, kMostBehind) * this.speed;
    this.#lastTick = now;
    if (!this.#seeking) {
      this.#advancing = this.#advance(this.#at + BigInt(Math.round(passed * 1e9))).catch((error: unknown) =>
        this.#fail(error),
      );
      await this.#advancing;
      this.changed.emit();
    }
    if (this.playing && !this.#closed) requestAnimationFrame((later) => void this.#tick(later));
  }

  async #advance(to: bigint): Promise<void> {
    const deadline = performance.now() + kTurn;
    const latest = new Map<number, RecordedMessage>();
    let reached = to;
    while (this.#messages && this.#goal === null) {
      if (!this.#next) {
        const result = await this.#messages.next();
        if (result.done === true) {
          this.#messages = null;
          break;
        }
        this.#next = result.value;
      }
      if (this.#next.time > to) break;
      if (performance.now() > deadline) {
        reached = this.#next.time; // slower than asked for, and nothing is left out
        break;
      }
      const message = this.#next;
      this.#next = null;
      if (kindOf(this.recording.channels.get(message.channel)?.schemaName ?? "") === "latest")
        latest.set(message.channel, message);
      else this.#take(message);
    }
    for (const message of latest.values()) this.#take(message);
    this.#at = reached < this.recording.end ? reached : this.recording.end;
    this.store.time = seconds(this.#at);
    this.store.touch("clock");
    if (this.#at >= this.recording.end) this.playing = false;
  }

  #take(message: RecordedMessage): void {
    const channel = this.recording.channels.get(message.channel);
    if (channel) this.ingest.take(`recorded ${channel.id}`, channel, () => channel.schema, message.time, message.data);
  }

  #fail(error: unknown): void {
    this.playing = false;
    this.trouble.emit(`${this.name}: ${error instanceof Error ? error.message : String(error)}`);
  }
}
