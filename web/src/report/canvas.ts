/** A picture of bodies in a figure, turned by pointer and touch; it is drawn when something changed. */

import {
  AmbientLight,
  Box3,
  Color,
  DirectionalLight,
  GridHelper,
  type Object3D,
  PerspectiveCamera,
  Raycaster,
  Scene,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const kHeight = 460; // px
const kFieldOfView = 40; // degrees
const kStill = 4; // px that a pointer may move within a click

export class Canvas {
  readonly element = document.createElement("canvas");
  readonly #renderer: WebGLRenderer;
  readonly #scene = new Scene();
  readonly #camera = new PerspectiveCamera(kFieldOfView, 1, 0.01, 50);
  readonly #controls: OrbitControls;
  #pending = false;

  /** `advance` is called before each picture; true: there will be another. Throws an Error without WebGL. */
  constructor(
    private readonly root: Object3D,
    private readonly advance: () => boolean,
  ) {
    this.element.tabIndex = 0;
    this.element.setAttribute("aria-label", "3-D view: drag to turn, wheel or two fingers to come near");
    this.#renderer = new WebGLRenderer({ canvas: this.element, antialias: true, preserveDrawingBuffer: true });
    this.#renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.#scene.background = new Color(0xf6f6f4);
    const grid = new GridHelper(2, 20, 0x999999, 0xd0d0d0);
    grid.rotation.x = Math.PI / 2;
    const light = new DirectionalLight(0xffffff, 2);
    light.position.set(-0.4, 0.9, 0.6);
    this.#camera.up.set(0, 0, 1);
    this.#camera.add(light);
    this.#scene.add(grid, root, new AmbientLight(0xffffff, 1.4), this.#camera);
    this.#controls = new OrbitControls(this.#camera, this.element);
    this.#controls.addEventListener("change", () => this.invalidate());
  }

  /** Fills the width of `frame`, from now on. */
  fill(frame: HTMLElement): void {
    new ResizeObserver(() => this.#resize(frame)).observe(frame);
    this.#resize(frame);
  }

  /** Shows all of `bodies`; what is in none of them may be out of the picture. */
  fit(bodies: Iterable<Object3D>): void {
    const box = new Box3();
    for (const body of bodies) box.expandByObject(body);
    if (box.isEmpty()) box.setFromObject(this.root);
    if (box.isEmpty()) box.set(new Vector3(-0.1, -0.1, 0), new Vector3(0.1, 0.1, 0.2));
    const middle = box.getCenter(new Vector3());
    const radius = Math.max(0.05, box.getSize(new Vector3()).length() / 2);
    const away = (1.1 * radius) / Math.sin((kFieldOfView * Math.PI) / 360);
    this.#camera.far = Math.max(50, 4 * away);
    this.#controls.target.copy(middle);
    this.#camera.position.copy(middle).add(new Vector3(-0.55, -0.65, 0.5).normalize().multiplyScalar(away));
    this.#camera.updateProjectionMatrix();
    this.#controls.update();
  }

  /** Calls back with the nearest visible body that is clicked at; a drag is no click. */
  onClick(callback: (body: Object3D | null) => void): void {
    let down = new Vector2();
    this.element.addEventListener("pointerdown", (event) => (down = new Vector2(event.offsetX, event.offsetY)));
    this.element.addEventListener("pointerup", (event) => {
      const at = new Vector2(event.offsetX, event.offsetY);
      if (at.distanceTo(down) > kStill) return;
      const place = new Vector2((2 * at.x) / this.element.clientWidth - 1, 1 - (2 * at.y) / this.element.clientHeight);
      const ray = new Raycaster();
      ray.setFromCamera(place, this.#camera);
      const isShown = (body: Object3D | null): boolean => !body || (body.visible && isShown(body.parent));
      const hit = ray.intersectObject(this.root, true).find(({ object }) => isShown(object));
      callback(hit?.object ?? null);
    });
  }

  invalidate(): void {
    if (this.#pending) return;
    this.#pending = true;
    requestAnimationFrame(() => {
      this.#pending = false;
      const goesOn = this.advance();
      this.#renderer.render(this.#scene, this.#camera);
      if (goesOn) this.invalidate();
    });
  }

  #resize(frame: HTMLElement): void {
    const width = Math.max(200, frame.clientWidth);
    this.#camera.aspect = width / kHeight;
    this.#camera.updateProjectionMatrix();
    this.#renderer.setSize(width, kHeight);
    this.invalidate();
  }
}

/** A box to tick that shows and hides `bodies`. */
export function hider(name: string, bodies: Object3D[], shown: boolean, canvas: Canvas): HTMLLabelElement {
  const label = document.createElement("label");
  const box = document.createElement("input");
  Object.assign(box, { type: "checkbox", checked: shown });
  const apply = () => {
    for (const body of bodies) body.visible = box.checked;
    canvas.invalidate();
  };
  box.addEventListener("change", apply);
  apply();
  label.append(box, ` ${name}`);
  return label;
}
