/** Figures of reports, turned by pointer and touch, each with its JSON: films of scenes, and robots whose joints move. */

import { Bodies, type SceneData } from "./bodies.js";
import { FilmFigure } from "./film.js";
import { RobotFigure } from "./robot.js";
import type { RobotData } from "./robot_body.js";

const kKinds: Record<string, (figure: HTMLElement, data: unknown) => unknown> = {
  scene: (figure, data) => new FilmFigure(figure, data as SceneData, new Bodies(data as SceneData)),
  robot: (figure, data) => new RobotFigure(figure, data as RobotData),
};

for (const [kind, draw] of Object.entries(kKinds)) {
  for (const figure of document.querySelectorAll<HTMLElement>(`figure.${kind}`)) {
    try {
      draw(figure, JSON.parse(figure.querySelector("script")?.textContent ?? "{}"));
    } catch (error) {
      const words = document.createElement("p");
      words.textContent = `This browser cannot draw it: ${String(error)}`;
      figure.prepend(words);
    }
  }
}
