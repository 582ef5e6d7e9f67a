// A report's film: it is drawn, played, turned and taken apart.

import assert from "node:assert/strict";
import { test } from "node:test";
import { base64, pixels, withFigure } from "./figure.mjs";

/** A square that faces up and rises by half a metre in half a second, and a plate that stays. */
function film() {
  const square = (side) => base64(new Float32Array([-side, -side, 0, side, -side, 0, side, side, 0, -side, side, 0]));
  const triangles = base64(new Uint32Array([0, 1, 2, 0, 2, 3]));
  const body = (name, color, side, poses) => ({
    name,
    color,
    opacity: 1,
    vertices: square(side),
    triangles,
    poses: base64(new Float32Array(poses)),
  });
  return {
    times: [3, 3.25, 3.5],
    captions: ["approach", "lift", "done"],
    bodies: [
      body("object 0", "#0000ff", 0.2, [0, 0, 0, 1, 0, 0, 0, 0, 0, 0.25, 1, 0, 0, 0, 0, 0, 0.5, 1, 0, 0, 0]),
      body("table", "#00ff00", 0.3, [0, 0, -0.05, 1, 0, 0, 0]),
    ],
  };
}

const withFilm = (data, body) => withFigure("scene", data, body);

test("what it shows moves with the time that is chosen", () =>
  withFilm(film(), async (page) => {
    await page.waitForSelector("figure.scene canvas");
    const low = await pixels(page, 2);
    assert.ok(low.count > 500, JSON.stringify(low));
    assert.match(await page.locator("output").innerText(), /0\.0 s: approach/);
    await page.getByLabel("Time").fill("2");
    const high = await pixels(page, 2);
    assert.ok(high.row < low.row - 30, `${JSON.stringify(low)} -> ${JSON.stringify(high)}`);
    assert.match(await page.locator("output").innerText(), /0\.5 s: done/);
  }));

test("it plays to its end, and again from the beginning", () =>
  withFilm(film(), async (page) => {
    const play = page.getByRole("button");
    for (let round = 0; round < 2; round++) {
      await play.click();
      await page.waitForFunction(() => document.querySelector("output").textContent.includes("done"));
      await page.waitForFunction(() => document.querySelector("button").textContent === "Play");
    }
  }));

test("parts are hidden by their names, and it is turned by dragging", () =>
  withFilm(film(), async (page) => {
    const before = await pixels(page, 1);
    assert.ok(before.count > 500, JSON.stringify(before));
    const box = await page.locator("canvas").boundingBox();
    await page.mouse.move(box.x + 200, box.y + 200);
    await page.mouse.down();
    await page.mouse.move(box.x + 200, box.y + 60, { steps: 5 });
    await page.mouse.up();
    const turned = await pixels(page, 1);
    assert.notEqual(turned.count, before.count);
    await page.getByLabel("table").uncheck();
    assert.equal((await pixels(page, 1)).count, 0);
    assert.ok((await pixels(page, 2)).count > 500);
  }));

test("a film of one moment has nothing to play", () =>
  withFilm({ ...film(), times: [3], captions: ["approach"] }, async (page) => {
    assert.ok((await pixels(page, 2)).count > 500);
    assert.equal(await page.getByRole("button").count(), 0);
  }));
