// What is done: choosing, executing, stopping, simulated time, parameters.

import assert from "node:assert/strict";
import { test } from "node:test";
import { eventually, useBrowser, withPage } from "./fixture.mjs";

useBrowser();

test("a click on an object chooses it, and Execute asks for its best grasp", () =>
  withPage(async ({ page, server }) => {
    const at = await page.evaluate(() => window.prehend.viewport.project(-0.14, 0.07, 0.05));
    await page.mouse.click(at.x, at.y);
    await page.waitForFunction(() => window.prehend.store.selection.object === 0);
    assert.match(
      await page.locator(".ledger").innerText(),
      /the arm cannot reach it[\s\S]*214[\s\S]*12 mm out of reach/,
    );
    // The nearest contact to the click, of all grasps, by the picture's own numbers.
    const [said, least] = await page.evaluate(() => {
      const { at } = window.prehend.store.selection;
      const distances = window.prehend.store.plans
        .get(0)
        .grasps.map(({ contacts }) =>
          Math.min(...contacts.map((p) => Math.hypot(p[0] - at[0], p[1] - at[1], p[2] - at[2]))),
        );
      return [document.querySelector(".ledger p").textContent, Math.min(...distances)];
    });
    assert.ok(least > 0 && least < 0.1);
    assert.match(said, new RegExp(`touches nearest, ${(1000 * least).toFixed(0)} mm away`));
    await page.locator("#card").getByRole("button", { name: "Execute" }).click();
    await eventually(() => server.calls.length === 1, "the call");
    assert.deepEqual(server.calls, [["/viewer/execute", { object: 0 }]]);
  }));

test("a drag turns the view and chooses nothing; a click on nothing chooses nothing", () =>
  withPage(async ({ page }) => {
    const at = await page.evaluate(() => window.prehend.viewport.project(-0.14, 0.07, 0.05));
    await page.mouse.move(at.x, at.y);
    await page.mouse.down();
    await page.mouse.move(at.x + 60, at.y + 10, { steps: 4 });
    await page.mouse.up();
    assert.equal(await page.evaluate(() => window.prehend.store.selection.object), null);
    const box = await page.locator("#view").boundingBox();
    await page.evaluate(() => window.prehend.store.select(1));
    await page.mouse.click(box.x + box.width - 15, box.y + box.height / 3);
    assert.equal(await page.evaluate(() => window.prehend.store.selection.object), null);
  }));

test("a grasp of the list is executed by keyboard", () =>
  withPage(async ({ page, server }) => {
    await page.getByRole("button", { name: /^Object 1/ }).press("Enter");
    await page.getByRole("button", { name: "Execute grasp 3 of object 1" }).press("Enter");
    await eventually(() => server.calls.length === 1, "the call");
    assert.deepEqual(server.calls[0], ["/viewer/execute", { object: 1, grasp: 2 }]);
  }));

test("an object without a grasp says why, and what would help", () =>
  withPage(async ({ page }) => {
    await page.getByRole("button", { name: /^Object 2/ }).click();
    const text = await page.locator("#side li.selected").innerText();
    assert.match(text, /no candidate passes/);
    assert.match(text, /6 mm more opening/);
    assert.equal(await page.locator("#card").getByRole("button", { name: "Execute" }).count(), 0);
  }));

test("what is refused, and what fails, is said in the server's words", () =>
  withPage(async ({ page, server }) => {
    server.services.set("/viewer/execute", () => ({ ok: false, message: "the arm is moving" }));
    await page.evaluate(() => window.prehend.store.select(0, 0));
    const execute = page.locator("#card").getByRole("button", { name: "Execute" });
    await execute.click();
    await page.getByText("Refused: the arm is moving").waitFor();
    server.services.set("/viewer/execute", () => {
      throw new Error("no cycle answers");
    });
    await execute.click();
    await page.getByText("no cycle answers").waitFor();
  }));

test("Escape, ! and the button stop; the reset is a click of its own", () =>
  withPage(async ({ page, server }) => {
    const calls = () => server.calls.map(([name]) => name);
    await page.keyboard.press("Escape");
    const banner = page.locator("#stop-banner");
    await banner.waitFor();
    assert.match(await banner.innerText(), /All motion is stopped[\s\S]*stopped on the viewer's page/);
    await banner.getByRole("button", { name: "Reset the stop" }).click();
    await banner.waitFor({ state: "hidden" });
    await page.keyboard.press("!");
    await banner.waitFor();
    await page.locator("#stop").click();
    await eventually(() => server.calls.length === 4, "the fourth call");
    assert.deepEqual(calls(), ["/viewer/stop", "/viewer/reset_stop", "/viewer/stop", "/viewer/stop"]);
  }));

test("a stop that cannot be sent is said loudly", () =>
  withPage(async ({ page, server }) => {
    await server.stop();
    await page.locator("#stop.unreachable").waitFor();
    await page.keyboard.press("Escape");
    await page.getByRole("alert").filter({ hasText: "NOT stopped" }).waitFor();
  }));

test("what nobody offers is hidden, or says why it cannot be done", () =>
  withPage(
    async ({ page, server }) => {
      server.publish("/plans", "prehend.msgs.GraspPlan", (await import("../world.mjs")).plan(0), { latched: true });
      await page.waitForFunction(() => window.prehend?.store.plans.size === 1);
      await page.evaluate(() => window.prehend.store.select(0, 0));
      assert.equal(await page.locator("#simulation").isVisible(), false);
      assert.equal(await page.locator("#card").getByRole("button", { name: "Execute" }).isDisabled(), true);
      assert.match(await page.locator("#card").innerText(), /nothing that runs offers this/);
    },
    { world: false },
  ));

test("simulated time is paused, stepped and sped up", () =>
  withPage(async ({ page, server }) => {
    await page.getByRole("button", { name: "Pause simulated time" }).click();
    await page.getByRole("button", { name: "Step" }).click();
    await page.getByLabel("Speed of simulated time").selectOption("0.5");
    await eventually(() => server.calls.length === 3, "the third call");
    assert.deepEqual(
      server.calls.map(([, request]) => request),
      [{ pause: true }, { step: 0.05 }, { speed: 0.5 }],
    );
  }));

test("parameters are set within their ranges, and what the node keeps is shown", () =>
  withPage(async ({ page, server }) => {
    await page.locator("#parameters > summary").click();
    const row = page.locator('[data-name="grasp_cycle.grasp_force"]');
    await page.locator(".node summary").first().click();
    const field = row.locator('input[type="number"]');
    await field.fill("40");
    await field.press("Enter");
    await row.getByText("set", { exact: true }).waitFor();
    await field.fill("400");
    await field.press("Enter");
    await row.getByText("it has to be within 0 and 100").waitFor();
    await field.fill("95"); // that the node refuses
    await field.press("Enter");
    await row.getByText("refused: it stays").waitFor();
    assert.equal(await field.inputValue(), "40");
    assert.deepEqual(server.settings, [
      ["grasp_cycle.grasp_force", 40],
      ["grasp_cycle.grasp_force", 95],
    ]);
  }));
