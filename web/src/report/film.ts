/** What a page shows of a scene: its picture, and below it what plays it and what hides parts of it. */

import type { Bodies, SceneData } from "./bodies.js";
import { Canvas, hider } from "./canvas.js";

const kBeside = ["arm", "table"]; // what the first picture need not show all of

export class FilmFigure {
  readonly #canvas: Canvas;
  readonly #slider = document.createElement("input");
  readonly #play = document.createElement("button");
  readonly #words = document.createElement("output");
  #since: { wall: number; time: number } | null = null; // that it plays

  /** Throws an Error when the browser has no WebGL. */
  constructor(
    figure: HTMLElement,
    private readonly data: SceneData,
    private readonly bodies: Bodies,
  ) {
    this.#canvas = new Canvas(bodies.root, () => this.#advance());
    figure.prepend(this.#canvas.element, this.#bar());
    this.#canvas.fit([...this.bodies.named].filter(([name]) => !kBeside.includes(name)).map(([, group]) => group));
    this.#show(0);
    this.#canvas.fill(figure);
  }

  #bar(): HTMLElement {
    const bar = document.createElement("div");
    const last = this.data.times.length - 1;
    this.#play.textContent = "Play";
    this.#play.addEventListener("click", () => this.#toggle());
    Object.assign(this.#slider, { type: "range", min: "0", max: String(last), value: "0" });
    this.#slider.setAttribute("aria-label", "Time");
    this.#slider.addEventListener("input", () => {
      this.#stop();
      this.#show(Number(this.#slider.value));
    });
    if (last > 0) bar.append(this.#play, this.#slider, this.#words);
    for (const [name, group] of this.bodies.named) bar.append(hider(name, [group], true, this.#canvas));
    return bar;
  }

  #toggle(): void {
    if (this.#since) return this.#stop();
    const { times } = this.data;
    const at = Number(this.#slider.value);
    const from = at >= times.length - 1 ? 0 : at;
    this.#since = { wall: performance.now(), time: times[from] ?? 0 };
    this.#play.textContent = "Pause";
    this.#canvas.invalidate();
  }

  #stop(): void {
    this.#since = null;
    this.#play.textContent = "Play";
  }

  /** The frame that is due while it plays; whether it still does. */
  #advance(): boolean {
    if (!this.#since) return false;
    const { times } = this.data;
    const now = this.#since.time + (performance.now() - this.#since.wall) / 1000;
    let frame = times.findIndex((time) => time > now);
    if (frame < 0) {
      frame = times.length;
      this.#stop();
    }
    this.#show(Math.max(0, frame - 1));
    return this.#since !== null;
  }

  #show(frame: number): void {
    this.#slider.value = String(frame);
    this.bodies.show(frame);
    const time = (this.data.times[frame] ?? 0) - (this.data.times[0] ?? 0);
    this.#words.textContent = `${time.toFixed(1)} s: ${this.data.captions[frame] ?? ""}`;
    this.#canvas.invalidate();
  }
}
