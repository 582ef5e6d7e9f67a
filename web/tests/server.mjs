// A server of the Foxglove WebSocket protocol and of the page, in the process of the tests: what the graph's own
// would be.

import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { WebSocketServer } from "ws";
import { schemaOf } from "./schemas.mjs";

const dist = join(dirname(fileURLToPath(import.meta.url)), "../dist");
const types = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript",
  ".css": "text/css",
  ".txt": "text/plain",
};

export const contentSecurityPolicy =
  "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' blob: data:; style-src 'self'; script-src 'self'; " +
  "worker-src 'self' blob:; object-src 'none'; base-uri 'none'; frame-ancestors 'none'";

export class TestServer {
  /** Calls of services as they came: [name, request]. */
  calls = [];
  /** Parameters that were set: [name, value]. */
  settings = [];
  /** Service name -> what it answers; a thrown Error is a failure of the call. */
  services = new Map();
  parameters = [];
  sessionId = "1";
  #channels = new Map(); // topic -> {id, schemaName}
  #latched = new Map(); // topic -> [[time, data], ...]
  #clients = new Set();
  #http;
  #sockets;

  /** Starts to listen on loopback; a port of 0 takes a free one. Returns the port. */
  async start(port = 0) {
    this.#http = createServer((request, response) => void this.#serve(request, response));
    this.#sockets = new WebSocketServer({
      server: this.#http,
      handleProtocols: (offered) =>
        ["foxglove.sdk.v1", "foxglove.websocket.v1"].find((name) => offered.has(name)) ?? false,
    });
    this.#sockets.on("connection", (socket) => this.#welcome(socket));
    await new Promise((resolve, reject) => {
      this.#http.once("error", reject);
      this.#http.listen(port, "127.0.0.1", resolve);
    });
    return this.#http.address().port;
  }

  async stop() {
    for (const client of this.#clients) client.socket.terminate();
    this.#sockets.close();
    this.#http.closeAllConnections();
    await new Promise((resolve) => this.#http.close(resolve));
  }

  get clientCount() {
    return this.#clients.size;
  }

  advertise(topic, schemaName) {
    if (this.#channels.has(topic)) return;
    const id = this.#channels.size + 1;
    this.#channels.set(topic, { id, schemaName });
    this.#all({ op: "advertise", channels: [this.#channel(topic)] });
  }

  /** A latched message comes to those who subscribe later, too; the last `keep` of a topic. */
  publish(topic, schemaName, data, { time = 0, latched = false, keep = 1 } = {}) {
    this.advertise(topic, schemaName);
    if (latched) this.#latched.set(topic, [...(this.#latched.get(topic) ?? []), [time, data]].slice(-keep));
    for (const client of this.#clients) {
      const subscription = client.subscriptions.get(this.#channels.get(topic).id);
      if (subscription !== undefined) client.socket.send(frame(subscription, time, data));
    }
  }

  sendTime(time) {
    const bytes = Buffer.alloc(9);
    bytes[0] = 2;
    bytes.writeBigUInt64LE(BigInt(Math.round(time * 1e9)), 1);
    this.sendRaw(bytes);
  }

  /** Anything, to all. */
  sendRaw(bytes) {
    for (const client of this.#clients) client.socket.send(bytes);
  }

  status(level, message, id) {
    this.#all({ op: "status", level, message, ...(id && { id }) });
  }

  isSubscribed(topic) {
    const channel = this.#channels.get(topic);
    return [...this.#clients].some((client) => channel && client.subscriptions.has(channel.id));
  }

  #all(message) {
    this.sendRaw(JSON.stringify(message));
  }

  #channel(topic) {
    const { id, schemaName } = this.#channels.get(topic);
    return {
      id,
      topic,
      encoding: "protobuf",
      schemaName,
      schemaEncoding: "protobuf",
      schema: schemaOf(schemaName).toString("base64"),
    };
  }

  #welcome(socket) {
    const client = { socket, subscriptions: new Map() };
    this.#clients.add(client);
    socket.on("close", () => this.#clients.delete(client));
    socket.on("message", (data, isBinary) => {
      if (isBinary) this.#call(socket, data);
      else this.#take(client, JSON.parse(data.toString()));
    });
    const send = (message) => socket.send(JSON.stringify(message));
    send({
      op: "serverInfo",
      name: "test world",
      capabilities: ["time", "services", "parameters", "parametersSubscribe"],
      supportedEncodings: ["json", "protobuf"],
      sessionId: this.sessionId,
    });
    send({ op: "advertise", channels: [...this.#channels.keys()].map((topic) => this.#channel(topic)) });
    const json = { encoding: "json", schemaName: "", schemaEncoding: "jsonschema", schema: "{}" };
    send({
      op: "advertiseServices",
      services: [...this.services.keys()].map((name, id) => ({ id, name, type: name, request: json, response: json })),
    });
  }

  #take({ socket, subscriptions }, message) {
    if (message.op === "subscribe") {
      for (const { id, channelId } of message.subscriptions) {
        subscriptions.set(channelId, id);
        const topic = [...this.#channels].find(([, channel]) => channel.id === channelId)?.[0];
        for (const [time, data] of this.#latched.get(topic) ?? []) socket.send(frame(id, time, data));
      }
    } else if (message.op === "unsubscribe") {
      for (const [channel, id] of subscriptions)
        if (message.subscriptionIds.includes(id)) subscriptions.delete(channel);
    } else if (message.op === "getParameters") {
      socket.send(JSON.stringify({ op: "parameterValues", parameters: this.parameters, id: message.id }));
    } else if (message.op === "setParameters") {
      for (const { name, value } of message.parameters) {
        this.settings.push([name, value]);
        const own = this.parameters.find((parameter) => parameter.name === name);
        if (own && !(typeof value === "number" && value > 90)) own.value = value; // more than 90 is refused
        socket.send(JSON.stringify({ op: "parameterValues", parameters: own ? [own] : [], id: message.id }));
      }
    }
  }

  #call(socket, data) {
    const [service, call, length] = [1, 5, 9].map((at) => data.readUInt32LE(at));
    const name = [...this.services.keys()][service];
    const request = JSON.parse(data.subarray(13 + length).toString());
    this.calls.push([name, request]);
    try {
      const answer = Buffer.from(JSON.stringify(this.services.get(name)(request)));
      const head = Buffer.alloc(17);
      head[0] = 3;
      head.writeUInt32LE(service, 1);
      head.writeUInt32LE(call, 5);
      head.writeUInt32LE(4, 9);
      head.write("json", 13);
      socket.send(Buffer.concat([head, answer]));
    } catch (error) {
      socket.send(
        JSON.stringify({ op: "serviceCallFailure", serviceId: service, callId: call, message: error.message }),
      );
    }
  }

  async #serve(request, response) {
    const { pathname } = new URL(request.url, "http://page");
    const name = pathname === "/" ? "index.html" : pathname.slice(1);
    try {
      if (!/^[\w.-]+$/.test(name)) throw new Error("no such file");
      const content = await readFile(join(dist, name));
      response.setHeader("Content-Type", types[name.slice(name.lastIndexOf("."))] ?? "application/octet-stream");
      response.setHeader("Content-Security-Policy", contentSecurityPolicy);
      response.end(content);
    } catch {
      response.statusCode = 404;
      response.end("no such file\n");
    }
  }
}

function frame(subscription, time, data) {
  const head = Buffer.alloc(13);
  head[0] = 1;
  head.writeUInt32LE(subscription, 1);
  head.writeBigUInt64LE(BigInt(Math.round(time * 1e9)), 5);
  return Buffer.concat([head, data]);
}
