/** Phases of the task as a band over time, and on it what surprised; below, each surprise in words. */

import type { App } from "../app.js";
import { byId, el, fill, panel } from "../dom.js";
import { clockText } from "../time.js";
import type { SurpriseMark } from "../scene/types.js";

const kSteps = ["waiting", "approach", "grasp", "lift", "move", "release", "done"];
const kMostListed = 60;

/** The band under the 3-D view. */
export function timeline(app: App): void {
  const { store } = app;
  const place = byId("timeline");
  const steps = el("ol", { class: "steps", "aria-label": "phases" });
  const detail = el("p", { class: "detail", role: "status" });
  const band = el("div", { class: "band", role: "img" });
  place.append(el("div", { class: "phase-line" }, steps, detail), band);

  const paint = (): void => {
    const now = store.phases.at(-1);
    const names = now && !kSteps.includes(now.phase) ? [...kSteps, now.phase] : kSteps;
    fill(
      steps,
      ...names.map((name) =>
        el("li", { "data-phase": name, ...(name === now?.phase && { "aria-current": "step" }) }, name),
      ),
    );
    const target = now && now.phase !== "waiting" ? `object ${now.object}, grasp ${now.grasp + 1}` : "";
    const task = store.taskState ? `task: ${store.taskState}` : "";
    const words = now?.detail && store.result.includes(now.detail) ? "" : now?.detail;
    detail.textContent = [store.result, words, target, task].filter(Boolean).join(" · ");
    detail.title = detail.textContent;
    paintBand();
  };
  const paintBand = (): void => {
    const { phases, surprises } = store;
    const first = Math.min(phases[0]?.time ?? Infinity, surprises[0]?.time ?? Infinity);
    band.hidden = !Number.isFinite(first);
    if (band.hidden) return;
    const last = Math.max(store.time || 0, phases.at(-1)?.time ?? 0, surprises.at(-1)?.time ?? 0, first + 1);
    const at = (time: number): string => `${(100 * (time - first)) / (last - first)}%`;
    const segments = phases.map((mark, i) => {
      const end = phases[i + 1]?.time ?? last;
      const segment = el(
        "div",
        { class: "segment", "data-phase": mark.phase, title: `${mark.phase}, ${clockText(mark.time)}: ${mark.detail}` },
        el("span", {}, mark.phase),
      );
      segment.style.left = at(mark.time);
      segment.style.width = `calc(${at(first + Math.max(0, end - mark.time))} - 1px)`;
      return segment;
    });
    const marks = surprises.map((mark) => {
      const tick = el("div", {
        class: `tick${mark.surprising ? " alarm" : ""}`,
        title: `${clockText(mark.time)} ${mark.name}: ${mark.felt} (${mark.predicted})`,
      });
      tick.style.left = at(mark.time);
      return tick;
    });
    band.replaceChildren(...segments, ...marks);
    const alarms = surprises.filter((mark) => mark.surprising).length;
    band.setAttribute("aria-label", `${phases.length} phases, ${alarms} surprises since ${clockText(first)}`);
  };
  store.watch(["cycle", "surprises"], paint);
  let lastBand = 0;
  store.watch(["clock"], () => {
    if (performance.now() - lastBand < 500) return;
    lastBand = performance.now();
    paintBand();
  });
  paint();
}

export function surprisesPanel(app: App): HTMLElement {
  const { store } = app;
  const { root, body, note } = panel("surprises", "Felt against predicted");
  const empty = el("p", { class: "muted" }, "Nothing has been touched yet.");
  const list = el("ol", { class: "surprises" });
  body.append(empty, list);
  const row = (mark: SurpriseMark): HTMLElement =>
    el(
      "li",
      { class: mark.surprising ? "alarm" : "" },
      el("span", { class: "number" }, clockText(mark.time)),
      el(
        "span",
        {},
        el("strong", {}, mark.name),
        " ",
        el("span", {}, `${mark.felt}, predicted ${mark.predicted}`),
        mark.reaction ? el("small", {}, mark.reaction) : null,
      ),
      el("span", { class: "badge" }, mark.surprising ? "surprise" : "as expected"),
    );
  store.watch(["surprises"], () => {
    empty.hidden = store.surprises.length > 0;
    const alarms = store.surprises.filter((mark) => mark.surprising).length;
    note.textContent = store.surprises.length > 0 ? `${alarms} of ${store.surprises.length} surprised` : "";
    fill(list, ...store.surprises.slice(-kMostListed).reverse().map(row));
  });
  return root;
}
