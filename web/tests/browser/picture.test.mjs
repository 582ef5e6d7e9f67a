// What is seen: colours of meshes and clouds, layouts, themes.

import assert from "node:assert/strict";
import { test } from "node:test";
import { hues, showOnly, useBrowser, withPage } from "./fixture.mjs";

useBrowser();

test("the meshes are drawn in the colours of what they rest on, and go with their layer", () =>
  withPage(async ({ page }) => {
    await showOnly(page, "shapes");
    const shown = await hues(page);
    for (const color of ["green", "blue", "orange"]) assert.ok(shown[color] > 60, `${color}: ${JSON.stringify(shown)}`);
    await showOnly(page);
    const hidden = await hues(page);
    for (const color of ["green", "blue"])
      assert.ok(hidden[color] < shown[color] / 10, `${color}: ${JSON.stringify(hidden)}`);
  }));

test("the cloud is coloured by image, by object and by depth", () =>
  withPage(async ({ page }) => {
    await showOnly(page, "cloud");
    const coloring = page.getByLabel("Colour of the cloud");
    const pictures = [];
    for (const mode of ["image", "object", "depth"]) {
      await coloring.selectOption(mode);
      pictures.push(await hues(page));
    }
    const [image, object, depth] = pictures;
    assert.ok(image.red > 60, JSON.stringify(image)); // the first thing is red in the image, blue as object 0
    assert.ok(object.red < image.red / 4 && object.orange > 60, JSON.stringify(object));
    assert.ok(
      depth.purple + depth.cyan + depth.yellow > image.purple + image.cyan + image.yellow + 60,
      JSON.stringify(depth),
    );
    assert.match(await page.locator("#legend .scale").innerText(), /0\.\d+ m[\s\S]*\d\.\d+ m/);
  }));

test("the arm moves with its frames", () =>
  withPage(async ({ page, step }) => {
    const tip = () =>
      page.evaluate(() => {
        const { view } = window.prehend.viewport;
        view.scene.updateMatrixWorld(true);
        let found = null;
        view.scene.traverse(
          (part) => part.userData.id === "robot/link_7" && (found = part.matrixWorld.elements.slice(12, 15)),
        );
        return found;
      });
    step(0);
    const before = await tip();
    step(2);
    await page.waitForFunction(() => window.prehend.store.time === 2);
    await page.waitForTimeout(100);
    const after = await tip();
    assert.ok(Math.hypot(...after.map((value, i) => value - before[i])) > 0.02, `${before} -> ${after}`);
  }));

test("400 pixels wide, nothing is cut off and the stop stays in view", () =>
  withPage(
    async ({ page, step }) => {
      for (let time = 0; time < 16; time += 0.5) step(time);
      await page.evaluate(() => {
        window.prehend.store.select(0, 0);
        for (const panel of document.querySelectorAll("details")) panel.open = true;
      });
      await page.waitForFunction(() => document.querySelectorAll(".parameter").length === 3);
      const width = await page.evaluate(() => [document.documentElement.scrollWidth, window.innerWidth]);
      assert.ok(width[0] <= width[1], `${width}`);
      await page.evaluate(() => window.scrollTo(0, 1200));
      const box = await page.locator("#stop").boundingBox();
      assert.ok(box.y >= 0 && box.y + box.height <= 860 && box.x >= 0 && box.x + box.width <= 400, JSON.stringify(box));
    },
    { viewport: { width: 400, height: 860 }, hasTouch: true },
  ));

test("dark as the system has it, and by the switch, which is kept", () =>
  withPage(
    async ({ page }) => {
      const brightness = () =>
        page.evaluate(
          () =>
            getComputedStyle(document.body)
              .backgroundColor.match(/\d+/g)
              .map(Number)
              .reduce((sum, value) => sum + value) / 3,
        );
      assert.ok((await brightness()) < 60);
      await page.getByRole("button", { name: "Light colours" }).click();
      assert.ok((await brightness()) > 200);
      await page.reload();
      assert.ok((await brightness()) > 200);
    },
    { colorScheme: "dark" },
  ));

test("whatever can be pressed or filled in has a name", () =>
  withPage(async ({ page }) => {
    await page.evaluate(() => {
      window.prehend.store.select(0, 0);
      for (const panel of document.querySelectorAll("details")) panel.open = true;
    });
    await page.waitForFunction(() => document.querySelectorAll(".parameter").length === 3);
    const nameless = await page.evaluate(() =>
      [...document.querySelectorAll("button, input, select, canvas, meter")]
        .filter((element) => !element.closest("[aria-hidden=true]") && element.getAttribute("aria-hidden") !== "true")
        .filter(
          (element) =>
            !(element.textContent.trim() && element.tagName === "BUTTON") &&
            !element.ariaLabel &&
            !element.closest("label"),
        )
        .map((element) => element.outerHTML.slice(0, 120)),
    );
    assert.deepEqual(nameless, []);
  }));

test("keys turn the view, and fit it", () =>
  withPage(async ({ page }) => {
    const place = () => page.evaluate(() => window.prehend.viewport.project(0.1, 0.1, 0.1));
    await page.locator("#view").focus();
    const before = await place();
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("ArrowUp");
    const turned = await place();
    assert.ok(Math.hypot(turned.x - before.x, turned.y - before.y) > 3);
    await page.keyboard.press("-");
    await page.keyboard.press("-");
    const center = () => page.evaluate(() => window.prehend.viewport.project(-0.14, 0.07, 0));
    const far = await center();
    await page.keyboard.press("f");
    const fitted = await center();
    assert.ok(Math.hypot(fitted.x - far.x, fitted.y - far.y) > 3);
  }));

test("labels of the truth are drawn when they are asked for", () =>
  withPage(async ({ page }) => {
    await showOnly(page);
    const without = await hues(page);
    await showOnly(page, "truth");
    const shown = await hues(page);
    assert.ok(shown.red > without.red + 60, JSON.stringify(shown));
  }));
