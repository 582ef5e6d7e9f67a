/** A text in the scene that always faces the viewer. */

import { CanvasTexture, LinearFilter, Sprite, SpriteMaterial, SRGBColorSpace } from "three";
import type { Color } from "../scene/types.js";

const kPixels = 40; // height of a line in the texture
const kLongest = 80; // letters; the lists have it whole
// m at 1 m: the height of a pixel in a view of 600 pixels and 42 degrees.
const kPixelSize = 0.00128;

/** `size`: m, or pixels where it is the same from everywhere. */
export function label(text: string, size: number, isScaleInvariant: boolean, color: Color): Sprite {
  const canvas = document.createElement("canvas");
  const shown = text.length > kLongest ? `${text.slice(0, kLongest - 1)}…` : text;
  const font = `600 ${Math.round(0.7 * kPixels)}px system-ui, sans-serif`;
  const measured = canvas.getContext("2d");
  if (measured) measured.font = font;
  canvas.width = Math.max(1, Math.ceil(measured?.measureText(shown).width ?? 1) + 16);
  canvas.height = kPixels;
  const context = canvas.getContext("2d");
  if (context) {
    context.font = font;
    context.textBaseline = "middle";
    context.fillStyle = "rgb(20 24 28 / 80%)"; // legible before light and dark
    context.beginPath();
    context.roundRect(0, 0, canvas.width, kPixels, 8);
    context.fill();
    context.fillStyle = `rgb(${color
      .slice(0, 3)
      .map((part) => 255 * (0.65 * part + 0.35))
      .join(" ")})`;
    context.fillText(shown, 8, kPixels / 2);
  }
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  map.minFilter = LinearFilter;
  const sprite = new Sprite(
    new SpriteMaterial({
      map,
      depthTest: false,
      transparent: true,
      opacity: color[3],
      sizeAttenuation: !isScaleInvariant,
    }),
  );
  const height = isScaleInvariant ? size * kPixelSize * 1.4 : size * 1.4;
  sprite.scale.set((height * canvas.width) / canvas.height, height, 1);
  sprite.renderOrder = 10;
  return sprite;
}
