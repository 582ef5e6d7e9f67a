/** The pads as live images in newtons, beside what the grasp predicts of them. */

import type { App } from "../app.js";
import { el, panel } from "../dom.js";
import type { PadImage } from "../scene/types.js";
import { kRamp } from "../view/ramp.js";
import { niceAtLeast } from "./scale.js";

interface PadView {
  root: HTMLElement;
  felt: HTMLCanvasElement;
  predicted: HTMLCanvasElement;
  sum: HTMLElement;
  predictedSum: HTMLElement;
}

const kLeastScale = 0.05; // N a cell, so that noise is not shown as touch

export function touchPanel(app: App): HTMLElement {
  const { store } = app;
  const { root, body, note } = panel("touch", "Touch");
  const empty = el("p", { class: "muted" }, "No pad has sent a frame yet.");
  const pads = el("div", { class: "pads" });
  const low = el("span", {}, "0");
  const high = el("span", {}, "");
  const bar = el("canvas", {
    width: 256,
    height: 1,
    class: "ramp",
    role: "img",
    "aria-label": "scale of force on a cell",
  });
  bar.getContext("2d")?.putImageData(new ImageData(new Uint8ClampedArray(kRamp), 256, 1), 0, 0);
  const scale = el("div", { class: "scale" }, low, bar, high);
  body.append(empty, pads, scale);
  const views = new Map<string, PadView>();
  let full = kLeastScale;

  const viewOf = (name: string): PadView => {
    const known = views.get(name);
    if (known) return known;
    const felt = el("canvas", { role: "img", "aria-label": `forces on ${name}` });
    const predicted = el("canvas", { role: "img", "aria-label": `predicted forces on ${name}` });
    const sum = el("span", { class: "number" });
    const predictedSum = el("span", { class: "number" });
    const figure = (canvas: HTMLCanvasElement, caption: string, value: HTMLElement): HTMLElement =>
      el("figure", {}, canvas, el("figcaption", {}, caption, value));
    const shown = el(
      "div",
      { class: "pad" },
      el("h3", {}, name.replaceAll("_", " ")),
      el("div", { class: "pad-images" }, figure(felt, "felt", sum), figure(predicted, "predicted", predictedSum)),
    );
    const view = { root: shown, felt, predicted, sum, predictedSum };
    views.set(name, view);
    pads.append(shown);
    return view;
  };

  const paint = (): void => {
    empty.hidden = store.pads.size > 0;
    scale.hidden = store.pads.size === 0;
    for (const [name, view] of [...views]) {
      if (store.pads.has(name)) continue;
      view.root.remove();
      views.delete(name);
    }
    if (!root.open) return;
    const { prediction, title } = predictionOf(app);
    note.textContent = title;
    let most = kLeastScale;
    for (const image of [...store.pads.values(), ...prediction.values()])
      for (const force of image.forces) most = Math.max(most, force);
    full = niceAtLeast(most);
    high.textContent = `${full} N a cell`;
    for (const [name, image] of store.pads) {
      const view = viewOf(name);
      drawPad(view.felt, image, full);
      view.sum.textContent = `${image.sum.toFixed(2)} N`;
      const expected = prediction.get(name) ?? prediction.get(name.replace(/_pad$/, ""));
      view.predicted.parentElement!.hidden = !expected;
      if (expected) {
        drawPad(view.predicted, expected, full);
        view.predictedSum.textContent = `${expected.sum.toFixed(2)} N`;
      }
    }
  };
  store.watch(["pads", "selection", "objects", "cycle"], paint);
  root.addEventListener("toggle", paint);
  paint();
  return root;
}

/** Of the grasp that is chosen, else of the one that runs. */
function predictionOf({ store }: App): { prediction: ReadonlyMap<string, PadImage>; title: string } {
  const { object, grasp } = store.selection;
  const phase = store.phases.at(-1);
  const chosen =
    object !== null
      ? store.plans.get(object)?.grasps[grasp ?? 0]
      : phase && store.plans.get(phase.object)?.grasps[phase.grasp];
  if (!chosen || chosen.predicted.size === 0) return { prediction: new Map(), title: "" };
  return { prediction: chosen.predicted, title: `beside grasp ${chosen.rank + 1} of object ${chosen.object}` };
}

/** One pixel a cell; the style sheet makes it large without smoothing. */
function drawPad(canvas: HTMLCanvasElement, image: PadImage, full: number): void {
  const { rows, columns, forces } = image;
  if (canvas.width !== columns || canvas.height !== rows) {
    canvas.width = columns;
    canvas.height = rows;
  }
  const context = canvas.getContext("2d");
  if (!context) return;
  const pixels = context.createImageData(columns, rows);
  for (let i = 0; i < forces.length; i++) {
    const place = Math.round(255 * Math.min(1, Math.max(0, forces[i]! / full)));
    pixels.data.set(kRamp.subarray(4 * place, 4 * place + 4), 4 * i);
  }
  context.putImageData(pixels, 0, 0);
}
