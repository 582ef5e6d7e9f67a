// How long the page works: npm run measure. At 300 000 points and 100 links, the processor's time of its main thread
// for a picture's messages (decoding, store, panels, scene), with the drawing itself left out, and the time until the
// first picture. Processor's time, so that what else runs on the machine does not count; the first picture is by the
// clock.

import { launch, whatIsMissing } from "./browser.mjs";
import { populate } from "./demo.mjs";
import { TestServer } from "./server.mjs";
import * as world from "./world.mjs";

const points = 300_000;
const links = 100;
const rounds = 60;

if (whatIsMissing() !== "") {
  console.log(whatIsMissing());
  process.exit(77);
}

const server = new TestServer();
const step = populate(server, { points, links });
for (let time = 0; time < 20; time += 0.05) step(time);
const port = await server.start();
const browser = await launch();
try {
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 800 } })).newPage();
  page.setDefaultTimeout(60_000);
  await page.goto(`http://127.0.0.1:${port}/`);
  await page.waitForFunction(
    () =>
      window.prehend?.store.cloud &&
      window.prehend.store.plans.size === 3 &&
      window.prehend.viewport.frameTimes.first > 0,
  );
  const first = await page.evaluate(() => window.prehend.viewport.frameTimes.first);
  const loaded = await page.evaluate(() => performance.getEntriesByType("navigation")[0].domContentLoadedEventEnd);
  await page.evaluate(() => (window.prehend.viewport.drawNow = () => {}));
  await page.waitForTimeout(1000);

  const session = await page.context().newCDPSession(page);
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  const script = async () => {
    const { metrics } = await session.send("Performance.getMetrics");
    return Object.fromEntries(metrics.map(({ name, value }) => [name, 1000 * value]));
  };
  const clouds = [world.cloud(points), world.cloud(points)];
  let time = 20;
  const measure = async (publish) => {
    const times = [];
    for (let i = 0; i < rounds; i++) {
      time += 1 / 30;
      const before = await script();
      publish(i);
      server.sendTime(time); // comes last
      await page.waitForFunction((last) => Math.abs(window.prehend.store.time - last) < 1e-6, time);
      await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve))));
      times.push((await script()).ScriptDuration - before.ScriptDuration);
    }
    return times.sort((a, b) => a - b);
  };
  const nothing = await measure(() => {}); // what measuring costs itself
  const moving = await measure(() => step(time));
  const clouded = await measure((i) => {
    step(time);
    server.publish("/viewer/cloud", "foxglove.PointCloud", clouds[i % 2]);
  });
  const said = (times) => {
    const at = (share) =>
      Math.max(0, times[Math.floor(share * times.length)] - nothing[nothing.length >> 1]).toFixed(2);
    return `median ${at(0.5)} ms, 90 % below ${at(0.9)} ms`;
  };
  console.log(`${points} points, ${links} links: the page's work a picture, apart from drawing`);
  console.log(`  arm, pads, wrench, clock:            ${said(moving)}`);
  console.log(`  the same and a new cloud each time:  ${said(clouded)}`);
  console.log(`document read ${loaded.toFixed(0)} ms, first picture ${first.toFixed(0)} ms after navigation began`);
} finally {
  await browser.close();
  await server.stop();
}
