/** Wrench, tactile sums and the gripper's opening over time. */

import type { App } from "../app.js";
import { byId, el } from "../dom.js";
import { LineChart, type Curve } from "./line_chart.js";

const kInterval = 100; // ms between pictures: faster is not read

export function signalsPanel(app: App): void {
  const { store } = app;
  const place = byId("signals");
  const empty = el("p", { class: "muted" }, "Wrench and touch over time appear here as soon as they are published.");
  place.append(empty);
  const charts = [
    { chart: new LineChart("Wrist force", "N", 1), prefix: "wrench F" },
    { chart: new LineChart("Force on pads", "N", 1), prefix: "pad " },
    { chart: new LineChart("Wrist torque", "N m", 0.05), prefix: "wrench T" },
    { chart: new LineChart("Gripper opening", "mm", 10, 1000), prefix: "gripper " },
  ];
  for (const { chart } of charts) {
    chart.root.hidden = true;
    place.append(chart.root);
  }
  let last = 0;
  let isWaiting = false;
  const paint = (): void => {
    const now = performance.now();
    if (now - last < kInterval) {
      if (!isWaiting) setTimeout(() => ((isWaiting = false), paint()), kInterval);
      isWaiting = true;
      return;
    }
    last = now;
    const drawn = charts.map(({ chart, prefix }) => {
      const curves: Curve[] = [];
      for (const [name, series] of store.series) {
        if (name.startsWith(prefix))
          curves.push({ name: name.slice(name.lastIndexOf(" ") + 1).replaceAll("_", " "), series });
      }
      curves.sort((a, b) => a.name.localeCompare(b.name));
      chart.root.hidden = curves.length === 0; // all of them before one is drawn: it changes their widths
      return { chart, curves };
    });
    for (const { chart, curves } of drawn) if (curves.length > 0) chart.draw(curves);
    empty.hidden = drawn.some(({ curves }) => curves.length > 0);
  };
  store.watch(["signals"], paint);
  window.addEventListener("theme", () => ((last = 0), paint()));
  new ResizeObserver(() => ((last = 0), paint())).observe(place);
}
