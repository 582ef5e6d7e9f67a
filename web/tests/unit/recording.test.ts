import assert from "node:assert/strict";
import { test } from "node:test";
import { Player } from "../../src/recording/player.js";
import { openRecording, type RecordedMessage, type Recording } from "../../src/recording/recording.js";
import { Taken } from "./testing.js";
// @ts-expect-error: plain JavaScript, shared with the browser's tests
import { writeRecording } from "../recorded.mjs";

const write = writeRecording as (options: object) => Promise<Uint8Array<ArrayBuffer>>;
const written = new Map<string, Promise<Uint8Array<ArrayBuffer>>>();

/** The same bytes each time: compressing takes longer than all else here. */
function record(options: { compression?: string; seconds?: number } = {}): Promise<Uint8Array<ArrayBuffer>> {
  const key = JSON.stringify(options);
  const bytes = written.get(key) ?? write(options);
  written.set(key, bytes);
  return bytes;
}

async function all(
  recording: Recording,
  from = recording.start,
  to = recording.end,
  reverse = false,
): Promise<RecordedMessage[]> {
  const topics = [...recording.channels.values()].map((channel) => channel.topic);
  const result: RecordedMessage[] = [];
  for await (const message of recording.messages({ topics, from, to, reverse })) result.push(message);
  return result;
}

test("a recording is the same with and without compression", async () => {
  const plain = await openRecording(new Blob([await record()]));
  const expected = await all(plain);
  assert.ok(expected.length > 500);
  assert.equal(plain.problem, "");
  for (const compression of ["zstd", "lz4"]) {
    const bytes = await record({ compression });
    assert.ok(bytes.length < 0.7 * (await record()).length);
    const read = await openRecording(new Blob([bytes]));
    assert.deepEqual([read.start, read.end], [plain.start, plain.end]);
    const messages = await all(read);
    assert.equal(messages.length, expected.length);
    messages.forEach((message, i) => assert.ok(Buffer.from(message.data).equals(Buffer.from(expected[i]!.data))));
  }
});

test("a part of the time is read, to and fro", async () => {
  const recording = await openRecording(new Blob([await record({ compression: "lz4" })]));
  const [from, to] = [recording.start + 2_000_000_000n, recording.start + 3_000_000_000n];
  const forward = await all(recording, from, to);
  assert.ok(forward.length > 20 && forward.every(({ time }) => time >= from && time <= to));
  const back = await all(recording, from, to, true);
  assert.deepEqual(
    back.map(({ time }) => time),
    forward.map(({ time }) => time).reverse(),
  );
});

test("a recording that was cut off is shown as far as it goes, wherever that is", async () => {
  const bytes = await record({ compression: "zstd" });
  const whole = (await all(await openRecording(new Blob([bytes])))).length;
  for (const share of [0.3, 0.6, 0.95, 0.999]) {
    const cut = await openRecording(new Blob([bytes.slice(0, Math.floor(share * bytes.length))]));
    const count = (await all(cut)).length;
    assert.ok(count > 0 && count <= whole, `${share}: ${count} of ${whole}`);
    assert.match(cut.problem, /missing or damaged/);
  }
  await assert.rejects(openRecording(new Blob([bytes.slice(0, 30)])), /no message|damaged/);
});

test("what is no recording, or a damaged one, is said in words", async () => {
  await assert.rejects(openRecording(new Blob(["PK\x03\x04 no recording at all"])), /does not begin as an MCAP file/);
  await assert.rejects(openRecording(new Blob([])), /does not begin as an MCAP file/);
  const bytes = await record({ compression: "lz4" });
  let state = 11;
  const random = (): number => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
  for (let i = 0; i < 25; i++) {
    const damaged = bytes.slice();
    for (let k = 0; k < 3; k++) damaged[8 + Math.floor(random() * (bytes.length - 8))] = 256 * random();
    try {
      await all(await openRecording(new Blob([damaged])));
    } catch (error) {
      assert.ok(error instanceof Error && error.message.length > 5);
    }
  }
});

test("a moment shows the state as it was, the last image before it and the signals that led there", async () => {
  const { store, ingest, troubles } = new Taken();
  const recording = await openRecording(new Blob([await record({ compression: "zstd" })]));
  const player = new Player("r.mcap", recording, store, ingest);
  assert.ok(player.topicCount >= 8);
  await player.seek(4);
  assert.deepEqual(troubles, []);
  assert.equal(store.phases.at(-1)?.phase, "waiting");
  assert.equal(store.objects.size, 3);
  const early = store.series.get("pad left_pad")!.length;
  await player.seek(10);
  assert.equal(store.phases.at(-1)?.phase, "grasp");
  assert.ok(store.series.get("pad left_pad")!.length > early);
  assert.equal(store.surprises.length, 2);
  await player.seek(4);
  assert.equal(store.surprises.length, 0);
  assert.ok(Math.abs(player.position - 4) < 1e-6);
  // Moments asked for faster than they are shown: the last one is.
  void player.seek(2);
  void player.seek(11);
  await player.seek(6);
  await new Promise((resolve) => setTimeout(resolve, 300));
  assert.ok(Math.abs(player.position - 6) < 1e-6);
});

test("it plays to its end, every message once, and stops there", { timeout: 20_000 }, async () => {
  const { store, ingest } = new Taken();
  const recording = await openRecording(new Blob([await record({ seconds: 6 })]));
  const player = new Player("r.mcap", recording, store, ingest);
  player.speed = 100;
  await player.seek(0);
  player.play(true);
  await new Promise<void>((resolve) => {
    const off = player.changed.on(() => {
      if (player.playing) return;
      off();
      resolve();
    });
  });
  assert.equal(player.position, player.duration);
  assert.deepEqual(
    store.phases.map((mark) => mark.phase),
    ["waiting", "approach"],
  );
});
