/** The canvas of the 3-D view: drawn when something changed, turned by pointer, touch and keys, clicked to choose. */

import {
  AmbientLight,
  Color,
  DirectionalLight,
  GridHelper,
  HemisphereLight,
  PerspectiveCamera,
  Raycaster,
  Sphere,
  Vector2,
  Vector3,
  WebGLRenderer,
  type Material,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Vector } from "../scene/types.js";
import type { Store } from "../scene/store.js";
import { isDrawnInSoftware } from "./graphics.js";
import { SceneView } from "./scene_view.js";

const kClickDistance = 5; // px, that a pointer may move between down and up
const kMostPointsInSoftware = 40_000;
const kIntervalInSoftware = 120; // ms between pictures, so that messages are read in time, too
const kTurn = Math.PI / 24; // rad, of an arrow key

export class Viewport {
  readonly view: SceneView;
  /** ms since navigation began, of the first picture with an object in it; 0: there was none yet. */
  readonly frameTimes = { first: 0 };
  /** `at`: m, world. */
  onClick: (id: string | null, at?: Vector) => void = () => {};

  readonly #renderer: WebGLRenderer;
  readonly #camera = new PerspectiveCamera(42, 1, 0.01, 50);
  readonly #controls: OrbitControls;
  readonly #grid = new GridHelper(2, 20);
  #pending = false;
  #interval = 0; // ms, at least, between pictures
  #lastDrawn = -1e9; // ms
  #fitted: "no" | "surroundings" | "objects" | "by hand" = "no";

  /** Throws an Error when the browser has no WebGL. */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    store: Store,
  ) {
    const inSoftware = isDrawnInSoftware();
    this.#renderer = new WebGLRenderer({ canvas, antialias: !inSoftware, powerPreference: "high-performance" });
    this.#renderer.setPixelRatio(inSoftware ? 1 : Math.min(window.devicePixelRatio, 2));
    this.view = new SceneView(store, () => this.invalidate());
    if (inSoftware) {
      this.view.cloud.mostDrawn = kMostPointsInSoftware;
      this.#interval = kIntervalInSoftware;
    }
    const { scene } = this.view;
    this.#camera.up.set(0, 0, 1);
    this.#camera.position.set(-0.75, -0.85, 0.75);
    this.#grid.rotation.x = Math.PI / 2;
    this.#grid.position.z = 0.0006; // over the table's top, which is where the world's frame is
    scene.add(this.#grid, new AmbientLight(0xffffff, 0.9), new HemisphereLight(0xffffff, 0xb8b2a8, 1.1));
    const light = new DirectionalLight(0xffffff, 1.5);
    light.position.set(-0.4, 0.9, 0.6);
    this.#camera.add(light);
    scene.add(this.#camera);

    this.#controls = new OrbitControls(this.#camera, canvas);
    this.#controls.enableDamping = false;
    this.#controls.minDistance = 0.05;
    this.#controls.maxDistance = 10;
    this.#controls.target.set(0, 0, 0.1);
    this.#controls.addEventListener("change", () => this.invalidate());
    this.#controls.addEventListener("start", () => (this.#fitted = "by hand"));
    this.#controls.update();
    this.#listen();
    store.watch(["entities", "cloud"], () => {
      const isLacking = this.#fitted === "no" || (this.#fitted === "surroundings" && this.view.hasShapes());
      if (isLacking && this.view.bounds()) {
        this.fit();
        this.#fitted = this.view.hasShapes() ? "objects" : "surroundings";
      }
    });
    new ResizeObserver(() => this.#resize()).observe(canvas);
    this.#resize();
  }

  /** Colours of the page's theme. */
  setTheme(background: string, grid: string, isDark: boolean): void {
    this.view.scene.background = new Color(background);
    const material = this.#grid.material as Material & { color: Color; vertexColors: boolean };
    material.vertexColors = false;
    material.color.set(grid);
    material.transparent = true;
    material.opacity = isDark ? 0.5 : 0.6;
    material.needsUpdate = true;
    this.invalidate();
  }

  /** Draws soon. */
  invalidate(): void {
    if (this.#pending) return;
    this.#pending = true;
    const draw = (): void => {
      this.#pending = false;
      this.#lastDrawn = performance.now();
      this.drawNow();
    };
    const wait = this.#lastDrawn + this.#interval - performance.now();
    if (wait > 0) setTimeout(() => requestAnimationFrame(draw), wait);
    else requestAnimationFrame(draw);
  }

  drawNow(): void {
    this.#renderer.render(this.view.scene, this.#camera);
    if (this.frameTimes.first === 0 && this.view.hasShapes()) this.frameTimes.first = performance.now();
  }

  /** Turns the camera so that all that matters is in view. */
  fit(): void {
    const box = this.view.bounds();
    if (!box) return;
    const sphere = box.getBoundingSphere(new Sphere());
    const radius = Math.max(sphere.radius, 0.15);
    const direction = this.#camera.position.clone().sub(this.#controls.target).normalize();
    const angle = (this.#camera.fov * Math.PI) / 360;
    const narrow = Math.min(1, this.#camera.aspect);
    this.#controls.target.copy(sphere.center);
    this.#camera.position.copy(sphere.center).addScaledVector(direction, (1.45 * radius) / (Math.sin(angle) * narrow));
    this.#controls.update();
    this.invalidate();
  }

  /** Looks along a direction of the world, at what is looked at now. */
  lookFrom(x: number, y: number, z: number): void {
    const distance = this.#camera.position.distanceTo(this.#controls.target);
    this.#camera.position.copy(this.#controls.target).addScaledVector(new Vector3(x, y, z).normalize(), distance);
    this.#controls.update();
    this.invalidate();
  }

  #listen(): void {
    const { canvas } = this;
    let down: { x: number; y: number } | null = null;
    canvas.addEventListener("pointerdown", (event) => {
      down = event.isPrimary && event.button === 0 ? { x: event.clientX, y: event.clientY } : null;
    });
    canvas.addEventListener("pointerup", (event) => {
      if (down && Math.hypot(event.clientX - down.x, event.clientY - down.y) <= kClickDistance) {
        const hit = this.pick(event.clientX, event.clientY);
        this.onClick(hit?.id ?? null, hit?.at);
      }
      down = null;
    });
    canvas.addEventListener("keydown", (event) => {
      const turns: Record<string, [number, number]> = {
        ArrowLeft: [-kTurn, 0],
        ArrowRight: [kTurn, 0],
        ArrowUp: [0, -kTurn],
        ArrowDown: [0, kTurn],
      };
      const turn = turns[event.key];
      if (turn) this.#orbit(turn[0], turn[1]);
      else if (event.key === "+" || event.key === "=") this.#zoom(1 / 1.15);
      else if (event.key === "-") this.#zoom(1.15);
      else if (event.key === "f" || event.key === "Home") this.fit();
      else return;
      event.preventDefault();
    });
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => this.invalidate());
  }

  /** What is at this place of the window, if it can be chosen. */
  pick(x: number, y: number): { id: string | null; at: Vector } | null {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.#camera);
    for (const hit of ray.intersectObject(this.view.pickable, true)) {
      let isShown = true;
      hit.object.traverseAncestors((ancestor) => (isShown &&= ancestor.visible));
      if (isShown) return { id: this.view.idOf(hit.object), at: [hit.point.x, hit.point.y, hit.point.z] };
    }
    return null;
  }

  /** Where a point of the world is in the window, px. */
  project(x: number, y: number, z: number): { x: number; y: number } {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector3(x, y, z).project(this.#camera);
    return { x: box.left + ((at.x + 1) / 2) * box.width, y: box.top + ((1 - at.y) / 2) * box.height };
  }

  #orbit(turn: number, tilt: number): void {
    const offset = this.#camera.position.clone().sub(this.#controls.target);
    const radius = offset.length();
    const azimuth = Math.atan2(offset.y, offset.x) + turn;
    const polar = Math.min(3.1, Math.max(0.04, Math.acos(offset.z / radius) + tilt));
    offset.set(Math.sin(polar) * Math.cos(azimuth), Math.sin(polar) * Math.sin(azimuth), Math.cos(polar));
    this.#camera.position.copy(this.#controls.target).addScaledVector(offset, radius);
    this.#controls.update();
    this.invalidate();
  }

  #zoom(factor: number): void {
    const offset = this.#camera.position.clone().sub(this.#controls.target).multiplyScalar(factor);
    this.#camera.position.copy(this.#controls.target).add(offset);
    this.#controls.update();
    this.invalidate();
  }

  #resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.#renderer.setSize(width, height, false);
    this.#camera.aspect = width / height;
    this.#camera.updateProjectionMatrix();
    this.view.cloud.setPointSize(0.0034 * height * this.#renderer.getPixelRatio());
    this.invalidate();
  }
}
