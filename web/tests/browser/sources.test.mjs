// Where it comes from: a server that goes and comes back, one that is hostile, files.

import assert from "node:assert/strict";
import { test } from "node:test";
import { populate } from "../demo.mjs";
import { writeRecording } from "../recorded.mjs";
import { TestServer } from "../server.mjs";
import { stopState } from "../world.mjs";
import { eventually, useBrowser, withPage } from "./fixture.mjs";

useBrowser();

test("after a restart it comes back by itself, and nothing of the run before is left", () =>
  withPage(async (stage) => {
    const { page, port } = stage;
    stage.step(12);
    await page.waitForFunction(() => window.prehend.store.phases.length > 0);
    await stage.server.stop();
    await page.locator('#connection[data-state="waiting"], #connection[data-state="connecting"]').waitFor();
    assert.equal(await page.evaluate(() => window.prehend.store.objects.size), 3); // what was seen stays until then
    stage.server = new TestServer();
    stage.server.sessionId = "2";
    stage.server.publish("/emergency_stop", "prehend.msgs.EmergencyStop", stopState(false), { latched: true });
    await stage.server.start(port);
    await page.locator('#connection[data-state="connected"]').waitFor();
    await page.waitForFunction(() => window.prehend.store.stop !== null && window.prehend.store.objects.size === 0);
    assert.equal(await page.evaluate(() => window.prehend.store.phases.length + window.prehend.store.entities.size), 0);
    populate(stage.server);
    await page.waitForFunction(() => window.prehend.store.plans.size === 3);
  }));

test("the same run, after the connection was lost, goes on with what it had", () =>
  withPage(async (stage) => {
    const { page, port } = stage;
    stage.step(12);
    await page.waitForFunction(() => window.prehend.store.phases.length > 0);
    const before = await page.evaluate(() => window.prehend.store.phases.length);
    await stage.server.stop();
    await stage.server.start(port);
    await page.waitForFunction(
      () => window.prehend.connection.state === "connected" && window.prehend.connection.channels.size > 5,
    );
    stage.step(12.5);
    await page.waitForFunction(() => window.prehend.store.time === 12.5);
    assert.equal(await page.evaluate(() => window.prehend.store.phases.length), before);
  }));

test("frames and messages that are garbage are said, and the page goes on", () =>
  withPage(async ({ page, server, step, wrong }) => {
    step(1); // the signals' channels begin with it
    await eventually(() => server.isSubscribed("/tactile/left"), "the subscription");
    let state = 5;
    const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
    for (let i = 0; i < 300; i++) {
      const bytes = Buffer.from({ length: Math.floor(60 * random()) }).map(() => 256 * random());
      // Every second one is a message of a subscription.
      if (bytes.length > 5 && i % 2 === 0) bytes.set([1, 1 + Math.floor(9 * random()), 0, 0, 0]);
      server.sendRaw(bytes);
    }
    for (const text of [
      "{",
      "[]",
      '{"op":"advertise","channels":5}',
      '{"op":"advertise","channels":[{"id":-1,"topic":"/x"}]}',
      '{"op":"serverInfo"}',
      '{"op":"status"}',
      '{"op":"parameterValues","parameters":[null,3,{"name":"a.b","value":{"c":[]}}]}',
      '{"op":"advertiseServices","services":[{"id":77,"name":"/viewer/execute<img src=x>"}]}',
      "x".repeat(200_000),
    ]) {
      server.sendRaw(text);
    }
    server.sendRaw(
      JSON.stringify({
        op: "advertise",
        channels: [{ id: 999, topic: "/evil", encoding: "protobuf", schemaName: "foxglove.Log", schema: "!!!" }],
      }),
    );
    server.status(2, "<img src=x onerror=alert(1)> is shown as it is", "evil");
    await page.getByText("<img src=x onerror=alert(1)> is shown as it is").waitFor();
    assert.equal(await page.locator("#notices img, #side img").count(), 0);
    for (let time = 30; time < 31; time += 0.1) step(time);
    await page.waitForFunction(
      () => window.prehend.store.series.get("pad left_pad")?.length > 5 && window.prehend.store.time < 31,
    );
    assert.deepEqual(wrong, []);
  }));

test("a server that says it dropped messages is heard, and taken back", () =>
  withPage(async ({ page, server }) => {
    server.status(1, "12 messages were dropped", "dropped");
    server.status(1, "40 messages were dropped", "dropped");
    await page.getByText("40 messages were dropped").waitFor();
    assert.equal(await page.getByText("12 messages were dropped").count(), 0);
    server.sendRaw(JSON.stringify({ op: "removeStatus", statusIds: ["dropped"] }));
    await page.getByText("40 messages were dropped").waitFor({ state: "detached" });
  }));

test("pictures are asked for only while somebody looks at them", () =>
  withPage(async ({ page, server }) => {
    assert.equal(server.isSubscribed("/viewer/image/left"), false);
    await page.locator("#pictures > summary").click();
    await page.waitForFunction(() => document.querySelector("#pictures canvas")?.width === 160);
    const pixel = await page.evaluate(() => [
      ...document.querySelector("#pictures canvas").getContext("2d").getImageData(40, 20, 1, 1).data,
    ]);
    assert.deepEqual(pixel, [90, 100, 120, 255]);
    await page.locator("#pictures > summary").click();
    await eventually(() => !server.isSubscribed("/viewer/image/left"), "the end of the subscription");
  }));

async function drop(page, bytes, name) {
  await page.evaluate(
    ([base64, fileName]) => {
      const data = new DataTransfer();
      data.items.add(new File([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))], fileName));
      window.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
    },
    [Buffer.from(bytes).toString("base64"), name],
  );
}

test("a recording that is dropped is replayed by the same panels, and live comes back", () =>
  withPage(async ({ page, server, step }) => {
    await drop(page, await writeRecording({ compression: "zstd" }), "run.mcap");
    await page.locator("#playback").waitFor();
    await page.waitForFunction(() => window.prehend.player() && window.prehend.store.series.has("wrench Fx"));
    assert.equal(await page.locator("#connection").innerText(), "recording");
    assert.equal(server.isSubscribed("/viewer/cloud"), false);
    await page.getByRole("button", { name: "Pause", exact: true }).click();
    const slider = page.getByLabel("Time of the recording");
    await slider.fill("13");
    await page.waitForFunction(() => window.prehend.store.phases.at(-1)?.phase === "lift");
    assert.match(await page.locator("#surprises").innerText(), /1 of 3 surprised/);
    assert.equal(await page.evaluate(() => window.prehend.store.entities.get("raw models").size), 3);
    step(50); // of the graph, which is not shown now
    await slider.fill("4");
    await page.waitForFunction(() => window.prehend.store.phases.at(-1)?.phase === "waiting");
    await page.getByRole("button", { name: "Play", exact: true }).click();
    await page.waitForFunction(
      () => window.prehend.store.time > 5.2 && window.prehend.store.phases.at(-1)?.phase === "approach",
    );
    await page.getByRole("button", { name: "Back to live" }).click();
    await page.waitForFunction(
      () => window.prehend.store.entities.has("/viewer/objects") && !window.prehend.store.entities.has("raw models"),
    );
  }));

test("a file that is no recording is refused in words, and what was shown stays", () =>
  withPage(async ({ page }) => {
    await drop(page, Buffer.from("no recording"), "notes.txt");
    await page.getByText("notes.txt cannot be shown: it does not begin as an MCAP file does").waitFor();
    assert.equal(await page.evaluate(() => window.prehend.store.plans.size), 3);
    const bytes = await writeRecording({ compression: "lz4" });
    await drop(page, bytes.slice(0, bytes.length / 2), "cut.mcap");
    await page.getByText(/cut.mcap: its end is missing or damaged/).waitFor();
    await page.waitForFunction(() => window.prehend.store.objects.size === 3 && window.prehend.player());
  }));
