/** Scenes of reports: turned by pointer and touch, played as films. Each is a figure of the class `scene` with its JSON. */

import { Bodies, type SceneData } from "./bodies.js";
import { SceneFigure } from "./figure.js";

for (const figure of document.querySelectorAll<HTMLElement>("figure.scene")) {
  const data = JSON.parse(figure.querySelector("script")?.textContent ?? "{}") as SceneData;
  try {
    new SceneFigure(figure, data, new Bodies(data));
  } catch (error) {
    const words = document.createElement("p");
    words.textContent = `This browser cannot draw it: ${String(error)}`;
    figure.prepend(words);
  }
}
