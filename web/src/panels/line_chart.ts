/** A chart of signals over the last seconds: one axis of time, one of the quantity, the newest at the right. */

import { cssColor, el } from "../dom.js";
import { kSpan, type Series } from "../scene/series.js";
import { niceAtLeast } from "./scale.js";

export interface Curve {
  name: string; // in the legend
  series: Series;
}

const kLeft = 40; // px, of the axis' numbers
const kBottom = 16;
const kColors = ["--curve-1", "--curve-2", "--curve-3", "--curve-4", "--curve-5", "--curve-6"];

export class LineChart {
  readonly root: HTMLElement;
  readonly #canvas = el("canvas", { role: "img" });
  readonly #legend = el("ul", { class: "legend" });
  #values: HTMLElement[] = [];
  #names = "";

  /**
   * `least`: that the axis spans, in its unit, so that noise stays small. `factor`: of the axis' unit in the series'
   * one.
   */
  constructor(
    private readonly title: string,
    private readonly unit: string,
    private readonly least: number,
    private readonly factor = 1,
  ) {
    this.#canvas.setAttribute("aria-label", title);
    const heading = el("h3", {}, title, el("small", {}, unit));
    this.root = el(
      "section",
      { class: "chart" },
      el("div", { class: "chart-head" }, heading, this.#legend),
      this.#canvas,
    );
  }

  draw(curves: Curve[]): void {
    this.#drawLegend(curves);
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    const context = this.#canvas.getContext("2d");
    if (!context || width === 0) return;
    const ratio = Math.min(window.devicePixelRatio, 2);
    const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.#canvas.width !== wide || this.#canvas.height !== high) {
      this.#canvas.width = wide;
      this.#canvas.height = high;
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);

    let end = -Infinity;
    for (const { series } of curves)
      if (series.length > 0) end = Math.max(end, series.times[series.place(series.length - 1)]!);
    if (!Number.isFinite(end)) return;
    const begin = end - kSpan;
    let [low, high_] = [0, 0];
    for (const { series } of curves) {
      for (let i = series.length - 1; i >= 0; i--) {
        const at = series.place(i);
        if (series.times[at]! < begin) break;
        low = Math.min(low, series.values[at]! * this.factor);
        high_ = Math.max(high_, series.values[at]! * this.factor);
      }
    }
    const step = niceAtLeast(Math.max(high_ - low, this.least) / 3);
    low = Math.floor(low / step) * step;
    high_ = Math.max(low + step, Math.ceil(high_ / step) * step);
    const right = width - 4;
    const bottom = height - kBottom;
    const x = (time: number): number => kLeft + ((time - begin) / kSpan) * (right - kLeft);
    const y = (value: number): number => bottom - 4 - ((value - low) / (high_ - low)) * (bottom - 10);
    this.#drawAxes(context, { x, y, begin, right, bottom, low, high: high_, step });
    curves.forEach(({ series }, i) => {
      context.strokeStyle = cssColor(kColors[i % kColors.length]!);
      context.lineWidth = 1.5;
      context.lineJoin = "round";
      context.beginPath();
      let column = -1;
      for (let k = 0; k < series.length; k++) {
        const at = series.place(k);
        if (series.times[at]! < begin) continue;
        const px = x(series.times[at]!);
        const isFirst = column < 0;
        // Two samples a pixel are enough.
        if (!isFirst && Math.floor(2 * px) === column && k < series.length - 1) continue;
        column = Math.floor(2 * px);
        if (isFirst) context.moveTo(px, y(series.values[at]! * this.factor));
        else context.lineTo(px, y(series.values[at]! * this.factor));
      }
      context.stroke();
    });
  }

  #drawAxes(
    context: CanvasRenderingContext2D,
    axes: {
      x: (time: number) => number;
      y: (value: number) => number;
      begin: number;
      right: number;
      bottom: number;
      low: number;
      high: number;
      step: number;
    },
  ): void {
    const { x, y, begin, right, bottom, low, high, step } = axes;
    context.font = "11px system-ui, sans-serif";
    context.lineWidth = 1;
    const digits = Math.max(0, -Math.floor(Math.log10(step)));
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (let value = low; value <= high + step / 2; value += step) {
      context.strokeStyle = cssColor(Math.abs(value) < step / 2 ? "--axis" : "--grid");
      context.beginPath();
      context.moveTo(kLeft, Math.round(y(value)) + 0.5);
      context.lineTo(right, Math.round(y(value)) + 0.5);
      context.stroke();
      context.fillStyle = cssColor("--muted");
      context.fillText(value.toFixed(digits), kLeft - 6, y(value));
    }
    context.textBaseline = "alphabetic";
    for (let back = kSpan; back >= 0; back -= 10) {
      context.textAlign = back === 0 ? "right" : back === kSpan ? "left" : "center";
      context.fillText(back === 0 ? "now" : `−${back} s`, x(begin + kSpan - back), bottom + kBottom - 4);
    }
  }

  #drawLegend(curves: Curve[]): void {
    const names = curves.map((curve) => curve.name).join("\n");
    if (names !== this.#names) {
      this.#names = names;
      this.#values = curves.map(() => el("span", { class: "number" }));
      this.#legend.replaceChildren(
        ...curves.map(({ name }, i) => {
          const key = el("span", { class: "key", "aria-hidden": "true" });
          key.style.background = `var(${kColors[i % kColors.length]!})`;
          return el("li", {}, key, name, this.#values[i]);
        }),
      );
    }
    curves.forEach(({ series }, i) => {
      const last = series.last();
      this.#values[i]!.textContent =
        last === undefined ? "" : (last * this.factor).toFixed(Math.abs(last * this.factor) < 10 ? 2 : 1);
    });
    const said = curves.map(
      ({ name, series }) => `${name} ${((series.last() ?? 0) * this.factor).toFixed(2)} ${this.unit}`,
    );
    this.#canvas.setAttribute("aria-label", `${this.title} over the last ${kSpan} s: ${said.join(", ")}`);
  }
}
