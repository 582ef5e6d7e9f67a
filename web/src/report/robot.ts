/** What a page shows of a robot: its picture, its tree with a slider for each joint, and what hides parts of it. */

import { Box3, type Object3D, Vector3 } from "three";
import { Canvas, hider } from "./canvas.js";
import { type JointData, RobotBody, type RobotData, rangeOf } from "./robot_body.js";

const kHidden = ["touched", "inertia"]; // layers that cover what is seen
const kAxis = 0.08; // length of an axis' arrow, of the robot's size
const kSweep = 4; // s, of a joint's way there and back

function valueText(joint: JointData, position: number): string {
  if (joint.kind === "prismatic") return `${(1000 * position).toFixed(1)} mm`;
  return `${((180 * position) / Math.PI).toFixed(1)}°`;
}

export class RobotFigure {
  readonly #body: RobotBody;
  readonly #canvas: Canvas;
  readonly #sliders: (HTMLInputElement | null)[];
  readonly #values: (HTMLOutputElement | null)[];
  readonly #names: HTMLButtonElement[] = [];
  readonly #words = document.createElement("output");
  readonly #sweep = document.createElement("button");
  #sweeping: { since: number; from: number[] } | null = null;

  /** Throws an Error when the browser has no WebGL. */
  constructor(
    figure: HTMLElement,
    private readonly data: RobotData,
  ) {
    this.#body = new RobotBody(data);
    this.#canvas = new Canvas(this.#body.root, () => this.#advance());
    this.#sliders = data.joints.map(() => null);
    this.#values = data.joints.map(() => null);
    const left = document.createElement("div");
    left.className = "view";
    const right = document.createElement("div");
    right.className = "tree";
    const hung = new Set(data.joints.map(({ child }) => child));
    data.links.forEach((_, i) => {
      if (!hung.has(i)) right.append(this.#branch(i, null));
    });
    left.append(this.#canvas.element, this.#layers(), this.#buttons(), this.#words);
    figure.prepend(left, right);
    this.#canvas.onClick((body) => this.#select(this.#body.linkOf(body)));
    const layer = this.#body.layers.get("seen") ?? [...this.#body.layers.values()].flat();
    this.#canvas.fit(layer);
    this.#show();
    this.#canvas.fill(left);
  }

  /** A link, and below it those that hang on it. */
  #branch(link: number, joint: number | null): HTMLElement {
    const children = this.data.joints.flatMap(({ parent }, i) => (parent === link ? [i] : []));
    const branch = document.createElement(children.length > 0 ? "details" : "div");
    if (branch instanceof HTMLDetailsElement) branch.open = true;
    const head = document.createElement(children.length > 0 ? "summary" : "div");
    const name = document.createElement("button");
    name.textContent = this.data.links[link]!.name;
    name.addEventListener("click", (event) => {
      event.preventDefault();
      this.#select(link);
    });
    this.#names[link] = name;
    if (joint !== null) head.append(this.#joint(joint));
    head.append(name);
    branch.append(head, ...children.map((i) => this.#branch(this.data.joints[i]!.child, i)));
    return branch;
  }

  #joint(i: number): HTMLElement {
    const joint = this.data.joints[i]!;
    const line = document.createElement("span");
    line.className = "joint";
    line.title = joint.words;
    const name = document.createElement("span");
    name.textContent = joint.name;
    line.append(name);
    if (joint.kind === "fixed" || joint.kind === "other") return line;
    const [lower, upper] = rangeOf(joint);
    const slider = document.createElement("input");
    Object.assign(slider, { type: "range", min: String(lower), max: String(upper), step: "any" });
    slider.disabled = joint.leader !== null;
    slider.setAttribute("aria-label", joint.name);
    slider.addEventListener("input", () => {
      this.#stop();
      this.#body.positions[i] = Number(slider.value);
      this.#show();
    });
    const value = document.createElement("output");
    const limit = (bound: number | null, otherwise: string) => {
      const text = document.createElement("small");
      text.textContent = bound === null ? otherwise : valueText(joint, bound);
      return text;
    };
    line.append(limit(joint.lower, "no limit"), slider, limit(joint.upper, "no limit"), value);
    // A summary is opened and closed by clicks, but not by those at its slider.
    line.addEventListener("click", (event) => event.preventDefault());
    this.#sliders[i] = slider;
    this.#values[i] = value;
    return line;
  }

  #layers(): HTMLElement {
    const bar = document.createElement("div");
    for (const [name, meshes] of this.#body.layers) {
      const isShown = !kHidden.includes(name) || (name === "touched" && !this.#body.layers.has("seen"));
      bar.append(hider(name, meshes, isShown, this.#canvas));
    }
    const size = new Box3().setFromObject(this.#body.root).getSize(new Vector3()).length();
    this.#body.drawAxes(kAxis * (Number.isFinite(size) && size > 0 ? size : 1));
    const axes: Object3D[] = this.#body.axes;
    if (axes.length > 0) bar.append(hider("axes", axes, false, this.#canvas));
    return bar;
  }

  #buttons(): HTMLElement {
    const bar = document.createElement("div");
    const button = (name: string, positions: () => number[]) => {
      const one = document.createElement("button");
      one.textContent = name;
      one.addEventListener("click", () => {
        this.#stop();
        positions().forEach((position, i) => (this.#body.positions[i] = position));
        this.#show();
      });
      bar.append(one);
    };
    const { joints, postures } = this.data;
    const rest = () => joints.map(({ start }) => start);
    button("Rest", rest);
    button("Middle", () =>
      joints.map((joint) => (joint.kind === "fixed" ? 0 : rangeOf(joint)[0] / 2 + rangeOf(joint)[1] / 2)),
    );
    for (const posture of postures) {
      button(posture.name, () => {
        const positions = [...this.#body.positions];
        for (const [joint, position] of posture.positions) positions[joint] = position;
        return positions;
      });
    }
    this.#sweep.textContent = "Sweep";
    this.#sweep.title = "Each joint in turn through its whole range";
    this.#sweep.addEventListener("click", () => {
      if (this.#sweeping) return this.#stop();
      this.#sweeping = { since: performance.now(), from: [...this.#body.positions] };
      this.#sweep.textContent = "Stop";
      this.#canvas.invalidate();
    });
    if (this.#sliders.some((slider) => slider && !slider.disabled)) bar.append(this.#sweep);
    return bar;
  }

  #stop(): void {
    this.#sweeping = null;
    this.#sweep.textContent = "Sweep";
  }

  /** The position that is due while joints are swept; whether they still are. */
  #advance(): boolean {
    if (!this.#sweeping) return false;
    const moving = this.data.joints.flatMap((_, i) => (this.#sliders[i]?.disabled === false ? [i] : []));
    const turn = (performance.now() - this.#sweeping.since) / 1000 / kSweep;
    const at = moving[Math.floor(turn)];
    this.#sweeping.from.forEach((position, i) => (this.#body.positions[i] = position));
    if (at === undefined) {
      this.#stop();
    } else {
      // From where it stood to one end, the other, and back.
      const [lower, upper] = rangeOf(this.data.joints[at]!);
      const from = this.#sweeping.from[at]!;
      const ways: [number, number][] = [
        [from, upper],
        [upper, lower],
        [lower, from],
      ];
      const part = 3 * (turn % 1);
      const [begin, end] = ways[Math.min(2, Math.floor(part))]!;
      this.#body.positions[at] = begin + (end - begin) * (part % 1);
    }
    this.#show();
    return this.#sweeping !== null;
  }

  #select(link: number | null): void {
    this.#body.mark(link);
    this.#names.forEach((name, i) => name.classList.toggle("marked", i === link));
    if (link !== null) this.#names[link]?.scrollIntoView({ block: "nearest" });
    this.#words.textContent = link === null ? "" : `${this.data.links[link]!.name}: ${this.data.links[link]!.words}`;
    this.#canvas.invalidate();
  }

  #show(): void {
    this.#body.move();
    this.data.joints.forEach((joint, i) => {
      const position = this.#body.positions[i]!;
      const slider = this.#sliders[i];
      if (slider) slider.value = String(position);
      const value = this.#values[i];
      if (value) value.textContent = valueText(joint, position);
    });
    this.#canvas.invalidate();
  }
}
