/**
 * A connection to a server of the Foxglove WebSocket protocol that comes back by itself: after 0.5 s, then twice as
 * long each time, at most 10 s. It keeps what the server advertises, subscribes to what `wants` names, and pairs
 * services' answers with their calls.
 */

import { Signal } from "../events.js";
import {
  parseFrame,
  parseMessage,
  serviceRequest,
  type Channel,
  type Parameter,
  type ServerFrame,
  type ServerMessage,
  type Service,
} from "./frames.js";

export type ConnectionState = "connecting" | "connected" | "waiting" | "closed";

const kSubprotocols = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
const kFirstWait = 500; // ms
const kLongestWait = 10_000; // ms
const kOpenTime = 5000; // ms, in which the server has to say who it is
const kCallTime = 10_000; // ms

interface PendingCall {
  service: number;
  resolve: (data: Uint8Array) => void;
  reject: (error: Error) => void;
  timer: ReturnType<typeof setTimeout>;
}

export class Connection {
  readonly stateChanged = new Signal<[ConnectionState]>();
  /** The server is another one than before, or a new run of it: all that came before is void. */
  readonly sessionChanged = new Signal<[]>();
  readonly message = new Signal<[channel: Channel, time: bigint, data: Uint8Array]>();
  readonly time = new Signal<[bigint]>();
  readonly status = new Signal<[level: number, text: string, id: string]>();
  readonly statusRemoved = new Signal<[string]>();
  readonly offersChanged = new Signal<[]>();
  readonly parameters = new Signal<[Parameter[]]>();
  /** What the server sent was not understood. */
  readonly trouble = new Signal<[string]>();

  state: ConnectionState = "closed";
  serverName = "";
  capabilities: string[] = [];
  /** Seconds until the next try, while waiting. */
  nextTry = 0;
  readonly channels = new Map<number, Channel>();
  readonly services = new Map<string, Service>();

  #socket: WebSocket | null = null;
  #session: string | null = null;
  #wait = kFirstWait;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #nextSubscription = 1;
  #nextCall = 1;
  readonly #subscribed = new Map<number, number>(); // channel -> subscription
  readonly #channelOf = new Map<number, Channel>(); // subscription -> channel
  readonly #calls = new Map<number, PendingCall>();

  /** `wants`: whether a channel is worth its traffic, asked again whenever channels come or go. */
  constructor(
    readonly address: string,
    private readonly wants: (channel: Channel, all: ReadonlyMap<number, Channel>) => boolean,
  ) {}

  open(): void {
    this.#clearTimer();
    this.#setState("connecting");
    let socket: WebSocket;
    try {
      socket = new WebSocket(this.address, kSubprotocols);
    } catch (error) {
      this.trouble.emit(`${this.address} is no address: ${String(error)}`);
      this.#setState("closed");
      return;
    }
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    socket.onmessage = (event: MessageEvent<unknown>) => this.#take(event.data);
    socket.onclose = () => this.#lost(socket);
    this.#timer = setTimeout(() => socket.close(), kOpenTime);
  }

  /** Ends it for good. */
  close(): void {
    this.#clearTimer();
    const socket = this.#socket;
    this.#socket = null;
    socket?.close();
    this.#forget("the connection was closed");
    this.#setState("closed");
  }

  /** Subscribes to what is wanted now and was not before, and the other way round. */
  refresh(): void {
    const fresh: { id: number; channelId: number }[] = [];
    const stale: number[] = [];
    for (const channel of this.channels.values()) {
      const subscription = this.#subscribed.get(channel.id);
      const wanted = this.wants(channel, this.channels);
      if (wanted && subscription === undefined) {
        const id = this.#nextSubscription++;
        this.#subscribed.set(channel.id, id);
        this.#channelOf.set(id, channel);
        fresh.push({ id, channelId: channel.id });
      } else if (!wanted && subscription !== undefined) {
        this.#unsubscribe(channel.id);
        stale.push(subscription);
      }
    }
    if (stale.length > 0) this.#send({ op: "unsubscribe", subscriptionIds: stale });
    if (fresh.length > 0) this.#send({ op: "subscribe", subscriptions: fresh });
  }

  /** Calls a service; its answer, or an error in words, after `patience` [ms] at the latest. */
  call(name: string, encoding: string, data: Uint8Array, patience = kCallTime): Promise<Uint8Array> {
    const service = this.services.get(name);
    if (this.state !== "connected") return Promise.reject(new Error("not connected"));
    if (!service) return Promise.reject(new Error(`${name} is not offered by what runs`));
    const call = this.#nextCall++;
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => {
        this.#calls.delete(call);
        reject(new Error(`${name} did not answer within ${patience / 1000} s`));
      }, patience);
      this.#calls.set(call, { service: service.id, resolve, reject, timer });
      this.#socket?.send(serviceRequest(service.id, call, encoding, data));
    });
  }

  /** Calls a service that talks JSON. */
  async callJson(name: string, request: unknown, patience = kCallTime): Promise<unknown> {
    const answer = await this.call(name, "json", new TextEncoder().encode(JSON.stringify(request)), patience);
    try {
      return JSON.parse(new TextDecoder().decode(answer));
    } catch {
      throw new Error(`${name} answered what is no JSON`);
    }
  }

  getParameters(names: string[] = []): void {
    if (this.capabilities.includes("parameters")) this.#send({ op: "getParameters", parameterNames: names, id: "get" });
  }

  setParameter(parameter: Parameter): void {
    this.#send({ op: "setParameters", parameters: [parameter], id: `set ${parameter.name}` });
  }

  #send(message: object): void {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(JSON.stringify(message));
  }

  #take(data: unknown): void {
    try {
      if (typeof data === "string") {
        const message = parseMessage(data);
        if (message) this.#takeMessage(message);
      } else if (data instanceof ArrayBuffer) {
        this.#takeFrame(parseFrame(data));
      }
    } catch (error) {
      this.trouble.emit(error instanceof Error ? error.message : String(error));
    }
  }

  #takeFrame(frame: ServerFrame): void {
    switch (frame.op) {
      case "message": {
        const channel = this.#channelOf.get(frame.subscription);
        if (channel) this.message.emit(channel, frame.time, frame.data); // else: unsubscribed since
        break;
      }
      case "time":
        this.time.emit(frame.time);
        break;
      case "serviceResponse": {
        const call = this.#endCall(frame.call);
        if (call) call.resolve(frame.data.slice());
        break;
      }
      case "assetResponse":
      case "playback":
        break; // this page asks for neither
    }
  }

  #takeMessage(message: ServerMessage): void {
    switch (message.op) {
      case "serverInfo":
        this.#clearTimer();
        this.#wait = kFirstWait;
        this.serverName = message.name;
        this.capabilities = message.capabilities;
        if (this.#session !== null && (this.#session !== message.sessionId || message.sessionId === "")) {
          this.sessionChanged.emit();
        }
        this.#session = message.sessionId;
        this.#setState("connected");
        if (this.capabilities.includes("parametersSubscribe")) {
          this.#send({ op: "subscribeParameterUpdates", parameterNames: [] });
        }
        this.getParameters();
        break;
      case "advertise":
        for (const channel of message.channels) {
          this.#unsubscribe(channel.id); // an id that is taken anew is another channel
          this.channels.set(channel.id, channel);
        }
        this.refresh();
        this.offersChanged.emit();
        break;
      case "unadvertise":
        for (const id of message.channelIds) {
          this.#unsubscribe(id);
          this.channels.delete(id);
        }
        this.refresh();
        this.offersChanged.emit();
        break;
      case "advertiseServices":
        for (const service of message.services) this.services.set(service.name, service);
        this.offersChanged.emit();
        break;
      case "unadvertiseServices":
        for (const service of [...this.services.values()]) {
          if (message.serviceIds.includes(service.id)) this.services.delete(service.name);
        }
        this.offersChanged.emit();
        break;
      case "serviceCallFailure":
        this.#endCall(message.callId)?.reject(new Error(message.message || "the server does not say why"));
        break;
      case "parameterValues":
        this.parameters.emit(message.parameters);
        break;
      case "status":
        this.status.emit(message.level, message.message, message.id);
        break;
      case "removeStatus":
        for (const id of message.statusIds) this.statusRemoved.emit(id);
        break;
      case "connectionGraphUpdate":
        break; // not asked for
    }
  }

  #unsubscribe(channel: number): void {
    const subscription = this.#subscribed.get(channel);
    if (subscription === undefined) return;
    this.#subscribed.delete(channel);
    this.#channelOf.delete(subscription);
  }

  #endCall(id: number): PendingCall | undefined {
    const call = this.#calls.get(id);
    if (call) {
      clearTimeout(call.timer);
      this.#calls.delete(id);
    }
    return call;
  }

  #lost(socket: WebSocket): void {
    if (socket !== this.#socket) return;
    this.#socket = null;
    this.#clearTimer();
    this.#forget("the connection was lost");
    this.nextTry = this.#wait / 1000;
    this.#timer = setTimeout(() => this.open(), this.#wait);
    this.#wait = Math.min(2 * this.#wait, kLongestWait);
    this.#setState("waiting");
  }

  #forget(why: string): void {
    this.channels.clear();
    this.services.clear();
    this.#subscribed.clear();
    this.#channelOf.clear();
    for (const id of [...this.#calls.keys()]) this.#endCall(id)?.reject(new Error(why));
    this.capabilities = [];
    this.offersChanged.emit();
  }

  #clearTimer(): void {
    clearTimeout(this.#timer);
  }

  #setState(state: ConnectionState): void {
    this.state = state;
    this.stateChanged.emit(state);
  }
}
