/** What a page shows of a scene: its picture, and below it what plays it and what hides parts of it. */

import {
  AmbientLight,
  Box3,
  Color,
  DirectionalLight,
  GridHelper,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Bodies, SceneData } from "./bodies.js";

const kHeight = 460; // px
const kFieldOfView = 40; // degrees
const kBeside = ["arm", "table"]; // what the first picture need not show all of

export class SceneFigure {
  readonly #renderer: WebGLRenderer;
  readonly #scene = new Scene();
  readonly #camera = new PerspectiveCamera(kFieldOfView, 1, 0.01, 50);
  readonly #controls: OrbitControls;
  readonly #slider = document.createElement("input");
  readonly #play = document.createElement("button");
  readonly #words = document.createElement("output");
  #since: { wall: number; time: number } | null = null; // that it plays
  #pending = false;

  /** Throws an Error when the browser has no WebGL. */
  constructor(
    private readonly figure: HTMLElement,
    private readonly data: SceneData,
    private readonly bodies: Bodies,
  ) {
    const canvas = document.createElement("canvas");
    canvas.tabIndex = 0;
    canvas.setAttribute("aria-label", "3-D view: drag to turn, wheel or two fingers to come near");
    this.#renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.#renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.#scene.background = new Color(0xf6f6f4);
    const grid = new GridHelper(2, 20, 0x999999, 0xd0d0d0);
    grid.rotation.x = Math.PI / 2;
    const light = new DirectionalLight(0xffffff, 2);
    light.position.set(-0.4, 0.9, 0.6);
    this.#camera.up.set(0, 0, 1);
    this.#camera.add(light);
    this.#scene.add(grid, bodies.root, new AmbientLight(0xffffff, 1.4), this.#camera);
    this.#controls = new OrbitControls(this.#camera, canvas);
    this.#controls.addEventListener("change", () => this.#invalidate());
    figure.prepend(canvas, this.#bar());
    this.#fit();
    this.#show(0);
    new ResizeObserver(() => this.#resize()).observe(figure);
    this.#resize();
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
    for (const [name, group] of this.bodies.named) {
      const label = document.createElement("label");
      const box = document.createElement("input");
      Object.assign(box, { type: "checkbox", checked: true });
      box.addEventListener("change", () => {
        group.visible = box.checked;
        this.#invalidate();
      });
      label.append(box, ` ${name}`);
      bar.append(label);
    }
    return bar;
  }

  #toggle(): void {
    if (this.#since) return this.#stop();
    const { times } = this.data;
    const at = Number(this.#slider.value);
    const from = at >= times.length - 1 ? 0 : at;
    this.#since = { wall: performance.now(), time: times[from] ?? 0 };
    this.#play.textContent = "Pause";
    this.#invalidate();
  }

  #stop(): void {
    this.#since = null;
    this.#play.textContent = "Play";
  }

  /** The frame that is due while it plays. */
  #advance(): void {
    if (!this.#since) return;
    const { times } = this.data;
    const now = this.#since.time + (performance.now() - this.#since.wall) / 1000;
    let frame = times.findIndex((time) => time > now);
    if (frame < 0) {
      frame = times.length;
      this.#stop();
    }
    this.#show(Math.max(0, frame - 1));
  }

  #show(frame: number): void {
    this.#slider.value = String(frame);
    this.bodies.show(frame);
    const time = (this.data.times[frame] ?? 0) - (this.data.times[0] ?? 0);
    this.#words.textContent = `${time.toFixed(1)} s: ${this.data.captions[frame] ?? ""}`;
    this.#invalidate();
  }

  #fit(): void {
    const box = new Box3();
    for (const [name, group] of this.bodies.named) if (!kBeside.includes(name)) box.expandByObject(group);
    if (box.isEmpty()) box.setFromObject(this.bodies.root);
    const middle = box.getCenter(new Vector3());
    const radius = Math.max(0.05, box.getSize(new Vector3()).length() / 2);
    const away = (1.1 * radius) / Math.sin((kFieldOfView * Math.PI) / 360);
    this.#controls.target.copy(middle);
    this.#camera.position.copy(middle).add(new Vector3(-0.55, -0.65, 0.5).normalize().multiplyScalar(away));
    this.#controls.update();
  }

  #resize(): void {
    const width = Math.max(200, this.figure.clientWidth);
    this.#camera.aspect = width / kHeight;
    this.#camera.updateProjectionMatrix();
    this.#renderer.setSize(width, kHeight);
    this.#invalidate();
  }

  #invalidate(): void {
    if (this.#pending) return;
    this.#pending = true;
    requestAnimationFrame(() => {
      this.#pending = false;
      this.#advance();
      this.#renderer.render(this.#scene, this.#camera);
      if (this.#since) this.#invalidate();
    });
  }
}
