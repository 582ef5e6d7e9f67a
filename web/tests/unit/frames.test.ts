import assert from "node:assert/strict";
import { test } from "node:test";
import { base64Bytes, parseFrame, parseMessage, ProtocolError, serviceRequest } from "../../src/protocol/frames.js";
import { serverAddress } from "../../src/address.js";

const bytes = (hex: string): ArrayBuffer =>
  Uint8Array.from(hex.trim().split(/\s+/), (byte) => Number.parseInt(byte, 16)).buffer;

// Frames as the protocol's description has them.
const message = "01 00 00 00 00 00 ca 9a 3b 00 00 00 00 09 00 00 00 00 00 00 f8 3f";
const time = "02 00 ca 9a 3b 00 00 00 00";
const response = "03 01 00 00 00 09 00 00 00 04 00 00 00 6a 73 6f 6e 7b 22 6f 6b 22 3a 74 72 75 65 7d";
const asset = "04 05 00 00 00 00 00 00 00 00 3c 72 6f 62 6f 74 2f 3e";

test("frames of the protocol's description are read", () => {
  const read = parseFrame(bytes(message));
  assert.equal(read.op, "message");
  if (read.op === "message") {
    assert.equal(read.subscription, 0);
    assert.equal(read.time, 1_000_000_000n);
    assert.equal(Buffer.from(read.data).toString("hex"), "09000000000000f83f");
  }
  assert.deepEqual(parseFrame(bytes(time)), { op: "time", time: 1_000_000_000n });
  const answer = parseFrame(bytes(response));
  assert.equal(answer.op, "serviceResponse");
  if (answer.op === "serviceResponse") {
    assert.deepEqual([answer.service, answer.call, answer.encoding], [1, 9, "json"]);
    assert.equal(new TextDecoder().decode(answer.data), '{"ok":true}');
  }
  const file = parseFrame(bytes(asset));
  assert.equal(file.op === "assetResponse" && new TextDecoder().decode(file.data), "<robot/>");
});

test("a request of a service is the description's", () => {
  const frame = serviceRequest(1, 9, "json", new TextEncoder().encode("{}"));
  assert.equal(Buffer.from(frame).toString("hex"), "02010000000900000004000000" + "6a736f6e" + "7b7d");
});

test("a frame that is cut off anywhere in its head is an error in words", () => {
  for (const [whole, head] of [
    [message, 13],
    [time, 9],
    [response, 17],
    [asset, 10],
  ] as const) {
    for (let length = 0; length < head; length++) {
      assert.throws(
        () => parseFrame(bytes(whole).slice(0, length)),
        (error) => error instanceof ProtocolError && error.message.length > 10,
      );
    }
  }
  assert.throws(() => parseFrame(bytes("03 01 00 00 00 09 00 00 00 ff ff ff ff 6a")), ProtocolError);
  assert.throws(() => parseFrame(bytes("7f 00")), /unknown opcode 127/);
});

test("random bytes and texts give frames or errors of the protocol, nothing else", () => {
  let state = 7;
  const random = (): number => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
  const values = [null, 1, -1, "x", [], {}, [null], [{}], [{ id: -1, topic: "/t" }], [{ name: "p" }]];
  const keys = [
    "channels",
    "services",
    "parameters",
    "channelIds",
    "statusIds",
    "capabilities",
    "id",
    "serviceId",
    "callId",
  ];
  const ops = [
    "serverInfo",
    "advertise",
    "unadvertise",
    "advertiseServices",
    "parameterValues",
    "status",
    "serviceCallFailure",
    "removeStatus",
    "?",
    3,
  ];
  for (let i = 0; i < 4000; i++) {
    const data = Uint8Array.from({ length: Math.floor(random() * 40) }, (_, at) =>
      at === 0 ? random() * 7 : random() * 256,
    );
    const text = JSON.stringify({
      op: ops[Math.floor(random() * ops.length)],
      ...Object.fromEntries(keys.map((key) => [key, values[Math.floor(random() * values.length)]])),
    });
    for (const read of [
      () => parseFrame(data.buffer),
      () => parseMessage(text),
      () => parseMessage(text.slice(0, 20 * random())),
    ]) {
      try {
        read();
      } catch (error) {
        assert.ok(error instanceof ProtocolError, String(error));
      }
    }
  }
});

test("what is advertised is read, in the older form of services, too", () => {
  const channels = parseMessage(
    '{"op":"advertise","channels":[{"id":3,"topic":"/p","encoding":"protobuf","schemaName":"t.P","schema":"AA=="}]}',
  );
  assert.equal(channels?.op === "advertise" && channels.channels[0]?.schemaName, "t.P");
  const services = parseMessage(
    '{"op":"advertiseServices","services":[{"id":1,"name":"/s","requestSchema":"a","responseSchema":"b"}]}',
  );
  assert.equal(services?.op === "advertiseServices" && services.services[0]?.response.schema, "b");
  assert.equal(parseMessage('{"op":"somethingNew"}'), null);
  assert.throws(() => base64Bytes("§"), ProtocolError);
});

test("the address is the page's own, or the one that is given; a token goes with it", () => {
  assert.equal(serverAddress(new URL("http://127.0.0.1:8765/")), "ws://127.0.0.1:8765/");
  assert.equal(serverAddress(new URL("https://robot/?token=a%20b")), "wss://robot/?token=a+b");
  assert.equal(serverAddress(new URL("http://here/?ws=ws://there:9/&token=t")), "ws://there:9/?token=t");
  assert.throws(() => serverAddress(new URL("http://here/?ws=nonsense")));
});
