// A robot in a page: its joints move by sliders, its layers are hidden, its links are chosen.

import assert from "node:assert/strict";
import { test } from "node:test";
import { base64, pixels, withFigure } from "./figure.mjs";

const kStill = [0, 0, 0, 1, 0, 0, 0];

/** A green foot, and a blue plate that slides up by 0.4 m and, by a second joint, turns as far in rad. */
function robot() {
  const square = base64(new Float32Array([-0.3, -0.3, 0, 0.3, -0.3, 0, 0.3, 0.3, 0, -0.3, 0.3, 0]));
  const shape = (link, layer, color) => ({ link, layer, color, mesh: 0, opacity: 1, pose: kStill });
  const joint = (name, kind, parent, child, more) => ({
    name,
    kind,
    parent,
    child,
    pose: kStill,
    child_pose: kStill,
    axis: [0, 0, 1],
    lower: 0,
    upper: 0.4,
    start: 0,
    leader: null,
    coefficients: [],
    words: "",
    ...more,
  });
  return {
    links: ["foot", "column", "plate"].map((name) => ({ name, words: `the ${name}'s mass` })),
    joints: [
      joint("lift", "prismatic", 0, 1),
      joint("turn", "revolute", 1, 2, { leader: 0, coefficients: [0, 1], lower: null, upper: null }),
    ],
    meshes: [{ vertices: square, triangles: base64(new Uint32Array([0, 1, 2, 0, 2, 3])) }],
    shapes: [shape(0, "seen", "#00ff00"), shape(2, "seen", "#0000ff"), shape(2, "inertia", "#ff0000")],
    postures: [{ name: "half", positions: [[0, 0.2]] }],
  };
}

const withRobot = (body) => withFigure("robot", robot(), body);
const values = (page) => page.locator(".joint output").allInnerTexts();

test("a slider moves what hangs on its joint, and what follows", () =>
  withRobot(async (page) => {
    assert.deepEqual(await values(page), ["0.0 mm", "0.0°"]);
    await page.getByLabel("lift").fill("0.4");
    assert.deepEqual(await values(page), ["400.0 mm", "22.9°"]);
    assert.ok(await page.getByRole("slider", { name: "turn" }).isDisabled());
    const high = await pixels(page, 2);
    await page.getByRole("button", { name: "half" }).click();
    assert.deepEqual(await values(page), ["200.0 mm", "11.5°"]);
    const middle = await pixels(page, 2);
    assert.ok(middle.row > high.row + 30, `${JSON.stringify(high)} -> ${JSON.stringify(middle)}`);
    await page.getByRole("button", { name: "Rest" }).click();
    assert.deepEqual(await values(page), ["0.0 mm", "0.0°"]);
  }));

test("layers that cover others are hidden first; a link that is clicked at is told of", () =>
  withRobot(async (page) => {
    await page.getByLabel("lift").fill("0.4");
    assert.equal((await pixels(page, 0)).count, 0);
    await page.getByLabel("seen").uncheck();
    await page.getByLabel("inertia").check();
    assert.ok((await pixels(page, 0)).count > 300);
    assert.equal((await pixels(page, 1)).count, 0);
    await page.getByRole("button", { name: "plate" }).click();
    assert.match(await page.locator(".view > output").innerText(), /plate: the plate's mass/);
    assert.equal(await page.locator("button.marked").innerText(), "plate");
  }));

test("joints are swept through their ranges and come back", () =>
  withRobot(async (page) => {
    await page.getByRole("button", { name: "Sweep" }).click();
    await page.waitForFunction(() => Number(document.querySelector(".joint input").value) > 0.1);
    await page.getByRole("button", { name: "Sweep" }).waitFor({ timeout: 20_000 });
    assert.deepEqual(await values(page), ["0.0 mm", "0.0°"]);
  }));
