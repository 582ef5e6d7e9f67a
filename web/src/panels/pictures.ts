/** What the cameras see. */

import { el, panel } from "../dom.js";
import type { Store } from "../scene/store.js";
import type { Picture } from "../scene/types.js";

/** `trouble` hears of pictures that cannot be drawn: what, and of which topic. */
export function picturesPanel(
  store: Store,
  trouble: (text: string, topic: string) => void,
): { root: HTMLDetailsElement } {
  const { root, body } = panel("pictures", "Cameras", false);
  const empty = el("p", { class: "muted" }, "No image has come yet.");
  const place = el("div", { class: "pictures" });
  body.append(empty, place);
  const views = new Map<string, { root: HTMLElement; canvas: HTMLCanvasElement; drawn: Picture | null }>();

  const paint = (): void => {
    empty.hidden = store.pictures.size > 0;
    for (const [topic, view] of [...views]) {
      if (store.pictures.has(topic)) continue;
      view.root.remove();
      views.delete(topic);
    }
    if (!root.open) return;
    for (const [topic, picture] of store.pictures) {
      let view = views.get(topic);
      if (!view) {
        const canvas = el("canvas", { role: "img", "aria-label": `image of ${topic}` });
        view = { root: el("figure", {}, canvas, el("figcaption", {}, topic)), canvas, drawn: null };
        views.set(topic, view);
        place.append(view.root);
      }
      if (view.drawn !== picture) {
        view.drawn = picture;
        void draw(view.canvas, picture).catch((error: unknown) => trouble(`${topic}: ${String(error)}`, topic));
      }
    }
  };
  store.watch(["pictures"], paint);
  root.addEventListener("toggle", paint);
  return { root };
}

async function draw(canvas: HTMLCanvasElement, picture: Picture): Promise<void> {
  const image = picture.kind === "compressed" ? await createImageBitmap(picture.blob) : null;
  const width = image?.width ?? (picture.kind === "pixels" ? picture.width : 0);
  const height = image?.height ?? (picture.kind === "pixels" ? picture.height : 0);
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d");
  if (image) {
    context?.drawImage(image, 0, 0);
    image.close();
  } else if (picture.kind === "pixels" && width > 0 && height > 0) {
    context?.putImageData(new ImageData(picture.rgba, width, height), 0, 0);
  }
}
