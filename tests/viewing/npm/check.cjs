// Looks at a viewer with the public client: node check.cjs PORT. Prints one line a check, "ok NAME" or
// "failed NAME: why", and ends with 1 when one failed. What the graph has: see npm_client_test.cpp.
const fs = require("fs");
const path = require("path");
const WebSocket = require("ws");
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const protobuf = require("protobufjs");
require("protobufjs/ext/descriptor");

const port = Number(process.argv[2]);
const address = `ws://127.0.0.1:${port}/`;
let failures = 0;

function within(promise, what, ms = 10000) {
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`${what} did not come`)), ms);
  });
  return Promise.race([promise, late]).finally(() => clearTimeout(timer));
}

async function check(name, work) {
  try {
    await work();
    console.log(`ok ${name}`);
  } catch (error) {
    ++failures;
    console.log(`failed ${name}: ${error.message}`);
  }
}

function expect(condition, what) {
  if (!condition) throw new Error(what);
}

class Viewer {
  constructor(subprotocol = "foxglove.websocket.v1") {
    this.channels = new Map();
    this.services = new Map();
    this.statuses = [];
    this.listeners = new Set();
    this.socket = new WebSocket(address, [subprotocol]);
    this.client = new FoxgloveClient({ ws: this.socket });
    this.client.on("serverInfo", (info) => (this.info = info));
    this.client.on("advertise", (all) => all.forEach((c) => this.channels.set(c.topic, c)));
    this.client.on("advertiseServices", (all) => all.forEach((s) => this.services.set(s.name, s)));
    this.client.on("status", (status) => this.statuses.push(status));
    this.client.on("error", (error) => (this.error = error));
    this.opened = new Promise((resolve, reject) => {
      this.client.on("open", resolve);
      this.socket.on("error", reject);
      this.socket.on("unexpected-response", (_, answer) => {
        answer.setEncoding("utf8");
        let text = "";
        answer.on("data", (part) => (text += part));
        answer.on("end", () => reject(new Error(`${answer.statusCode} ${text}`)));
      });
    });
  }
  async until(condition, what) {
    await within(
      (async () => {
        while (!condition()) await new Promise((resolve) => setTimeout(resolve, 5));
      })(),
      what,
    );
  }
  next(event, what = event) {
    return within(
      new Promise((resolve) => {
        const listener = (value) => {
          this.client.off(event, listener);
          resolve(value);
        };
        this.client.on(event, listener);
      }),
      what,
    );
  }
  async channel(topic) {
    await this.until(() => this.channels.has(topic), `channel ${topic}`);
    return this.channels.get(topic);
  }
  async message(topic) {
    const channel = await this.channel(topic);
    const message = this.next("message", `a message of ${topic}`);
    const subscription = this.client.subscribe(channel.id);
    const got = await message;
    expect(got.subscriptionId === subscription, "another subscription");
    return { channel, subscription, ...got };
  }
  close() {
    this.client.close();
  }
}

function type(schemaName, base64) {
  const bytes = Buffer.from(base64, "base64");
  const root = protobuf.Root.fromDescriptor(bytes);
  return root.lookupType(schemaName);
}

function decoded(message) {
  const its = type(message.channel.schemaName, message.channel.schema);
  return its.toObject(its.decode(new Uint8Array(message.data.buffer, message.data.byteOffset,
    message.data.byteLength)), { longs: Number, enums: String, bytes: Buffer, defaults: true });
}

// Names of the fields of @foxglove/schemas' JSON Schema of a message.
function publicFields(name) {
  const folder = path.join(path.dirname(require.resolve("@foxglove/schemas/package.json")), "dist");
  const schemas = require("@foxglove/schemas/jsonschema");
  expect(schemas[name], `@foxglove/schemas in ${folder} has no ${name}`);
  return Object.keys(schemas[name].properties).sort();
}

(async () => {
  for (const subprotocol of ["foxglove.websocket.v1", "foxglove.sdk.v1"]) {
    await check(`opens with ${subprotocol}`, async () => {
      const viewer = new Viewer(subprotocol);
      await within(viewer.opened, "open");
      await viewer.until(() => viewer.info, "serverInfo");
      expect(viewer.info.capabilities.includes("parameters"), "no parameters");
      viewer.close();
    });
  }
  await check("refuses an unknown sub-protocol", async () => {
    const viewer = new Viewer("other.v1");
    let why = "";
    try {
      await within(viewer.opened, "refusal");
    } catch (error) {
      why = error.message;
    }
    expect(why.startsWith("400"), `it said: ${why}`);
  });

  const viewer = new Viewer();
  await check("is told of channels", async () => {
    await within(viewer.opened, "open");
    await viewer.channel("/models");
    await viewer.channel("/viewer/objects");
  });
  await check("every schema is decodable", async () => {
    for (const channel of viewer.channels.values()) {
      expect(channel.encoding === "protobuf", `${channel.topic} is ${channel.encoding}`);
      type(channel.schemaName, channel.schema);
    }
  });
  await check("foxglove types have the public fields", async () => {
    const names = new Set();
    for (const channel of viewer.channels.values()) {
      if (!channel.schemaName.startsWith("foxglove.")) continue;
      const root = protobuf.Root.fromDescriptor(Buffer.from(channel.schema, "base64"));
      const foxglove = root.lookup("foxglove");
      for (const nested of foxglove.nestedArray) {
        if (!(nested instanceof protobuf.Type)) continue;
        const fields = nested.fieldsArray.map((field) => field.name).sort();
        // What protobufjs does to a field's name it does to the public one, too.
        const ours = fields.map((name) => name.toLowerCase().replace(/_/g, ""));
        const theirs = publicFields(nested.name).map((name) => name.toLowerCase().replace(/_/g, ""));
        expect(ours.sort().join() === theirs.sort().join(), `${nested.name}: ${ours} / ${theirs}`);
        names.add(nested.name);
      }
    }
    expect(names.size > 15, `only ${names.size} types were compared`);
  });
  await check("a latched topic comes to a late viewer", async () => {
    const model = decoded(await viewer.message("/models"));
    expect(model.id === 3, `object ${model.id}`);
  });
  await check("an object comes as a scene", async () => {
    const update = decoded(await viewer.message("/viewer/objects"));
    expect(update.entities[0].id === "object/3", JSON.stringify(update.entities[0].id));
    expect(update.entities[0].triangles[0].points.length === 8, "not a box");
  });
  await check("unsubscribing ends the frames", async () => {
    const first = await viewer.message("/clock_like");
    viewer.client.unsubscribe(first.subscription);
    await new Promise((resolve) => setTimeout(resolve, 300));
    let more = 0;
    const count = (event) => (more += event.subscriptionId === first.subscription ? 1 : 0);
    viewer.client.on("message", count);
    await new Promise((resolve) => setTimeout(resolve, 300));
    viewer.client.off("message", count);
    expect(more === 0, `${more} messages came`);
  });
  await check("the time is told", async () => {
    const { timestamp } = await viewer.next("time");
    expect(timestamp > 0n, `${timestamp}`);
  });
  await check("a parameter is set and told", async () => {
    viewer.client.subscribeParameterUpdates(["talker.gain"]);
    const answer = viewer.next("parameterValues");
    viewer.client.setParameters([{ name: "talker.gain", value: 2.5, type: "float64" }], "q1");
    const values = await answer;
    expect(values.parameters[0].value === 2.5, JSON.stringify(values));
    const asked = viewer.next("parameterValues");
    viewer.client.getParameters(["talker.gain"], "q2");
    expect((await asked).parameters[0].value === 2.5, "it is another one when it is asked for");
  });
  await check("a refused parameter is said", async () => {
    const before = viewer.statuses.length;
    viewer.client.setParameters([{ name: "talker.gain", value: 250, type: "float64" }], "q3");
    await viewer.until(() => viewer.statuses.length > before, "status");
    expect(viewer.statuses.at(-1).message.includes("gain"), viewer.statuses.at(-1).message);
  });
  await check("a service is called, and fails in words", async () => {
    await viewer.until(() => viewer.services.has("/talk"), "service");
    const service = viewer.services.get("/talk");
    const request = type(service.request.schemaName, service.request.schema);
    const response = type(service.response.schemaName, service.response.schema);
    const call = (callId, name) => {
      const bytes = request.encode(request.create({ name })).finish();
      viewer.client.sendServiceCallRequest({
        serviceId: service.id,
        callId,
        encoding: "protobuf",
        data: new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength),
      });
    };
    const answer = viewer.next("serviceCallResponse");
    call(1, "well");
    const { data } = await answer;
    const said = response.decode(new Uint8Array(data.buffer, data.byteOffset, data.byteLength));
    expect(said.reason === "talked to well", JSON.stringify(said));
    const failure = viewer.next("serviceCallFailure");
    call(2, "badly");
    expect((await failure).message.includes("not badly"), JSON.stringify(await failure));
  });
  await check("a topic is published", async () => {
    const channel = viewer.client.advertise({
      topic: "/from_viewer",
      encoding: "json",
      schemaName: "prehend.msgs.NamedThing",
      schema: viewer.services.get("/talk").request.schema,
      schemaEncoding: "protobuf",
    });
    viewer.client.sendMessage(channel, Buffer.from('{"name": "hello"}'));
    await new Promise((resolve) => setTimeout(resolve, 100));
  });
  await check("the connection graph is told", async () => {
    const update = viewer.next("connectionGraphUpdate");
    viewer.client.subscribeConnectionGraph();
    const { publishedTopics } = await update;
    expect(publishedTopics.some((t) => t.name === "/models"), JSON.stringify(publishedTopics));
  });
  await check("an asset is fetched", async () => {
    const answer = viewer.next("fetchAssetResponse");
    viewer.client.fetchAsset("package://prehend/config/robots/stage_pg70.yaml", 5);
    const { status, data } = await answer;
    expect(status === 0 && Buffer.from(data.buffer, data.byteOffset, data.byteLength).includes("arm:"),
      `status ${status}`);
  });
  viewer.close();
  process.exit(failures === 0 ? 0 : 1);
})();
