/** What stands over the 3-D view: what is shown in it, the legend of its colours, and the card of what was chosen. */

import type { App } from "../app.js";
import { byId, el, fill } from "../dom.js";
import { kOrigins } from "../scene/types.js";
import type { CloudColoring } from "../view/cloud_points.js";
import { kRamp } from "../view/ramp.js";
import type { GraspChoice, Layer } from "../view/scene_view.js";
import type { Viewport } from "../view/viewport.js";
import { execute, kExecuteService } from "./objects.js";

const kLayers: [Layer, string][] = [
  ["cloud", "Cloud"],
  ["shapes", "Shapes"],
  ["alternatives", "Alternatives"],
  ["grasps", "Grasps"],
  ["robot", "Robot"],
  ["truth", "Truth"],
];

export function stagePanel(app: App, viewport: Viewport): void {
  const { view } = viewport;
  const { store } = app;
  const toggles = kLayers.map(([layer, title]) => {
    const box = el("input", {
      type: "checkbox",
      "data-layer": layer,
      onchange: () => {
        view.visible[layer] = box.checked;
        view.applyVisibility();
      },
    });
    box.checked = view.visible[layer];
    return el("label", { class: "toggle" }, box, title);
  });
  const coloring = el("select", { "aria-label": "Colour of the cloud", onchange: () => recolor() });
  coloring.append(
    ...(["image", "object", "depth"] as const).map((mode) => el("option", { value: mode }, `by ${mode}`)),
  );
  const grasps = el("select", { "aria-label": "Grasps that are drawn", onchange: () => regrasp() });
  grasps.append(
    el("option", { value: "selected" }, "of the chosen object"),
    el("option", { value: "best" }, "best of each"),
    el("option", { value: "all" }, "all"),
  );
  const recolor = (): void => {
    view.cloud.coloring = coloring.value as CloudColoring;
    view.takeCloud();
    paintLegend();
  };
  const regrasp = (): void => {
    view.graspChoice = grasps.value as GraspChoice;
    view.applyVisibility();
  };
  const cameras: [string, () => void][] = [
    ["Fit", () => viewport.fit()],
    ["Front", () => viewport.lookFrom(-1, 0, 0.35)],
    ["Side", () => viewport.lookFrom(0, -1, 0.35)],
    ["Top", () => viewport.lookFrom(-0.01, 0, 1)],
  ];
  byId("layers").append(
    ...toggles.slice(0, 1),
    coloring,
    ...toggles.slice(1, 4),
    grasps,
    ...toggles.slice(4),
    el(
      "span",
      { class: "views", role: "group", "aria-label": "Look from" },
      ...cameras.map(([name, go]) => el("button", { class: "small", onclick: go }, name)),
    ),
  );

  const legend = byId("legend");
  const depth = el("div", { class: "scale" });
  const thinned = el("small", { title: "This browser draws without a graphics card" });
  const ramp = el("canvas", { width: 256, height: 1, class: "ramp", role: "img", "aria-label": "scale of depth" });
  ramp.getContext("2d")?.putImageData(new ImageData(new Uint8ClampedArray(kRamp), 256, 1), 0, 0);
  legend.append(
    el(
      "ul",
      { "aria-label": "What a surface rests on" },
      ...kOrigins.map(({ name, color }) => {
        const key = el("span", { class: "swatch", "aria-hidden": "true" });
        key.style.background = `rgb(${color
          .slice(0, 3)
          .map((value) => 255 * value)
          .join(" ")})`;
        return el("li", {}, key, name);
      }),
    ),
    depth,
    thinned,
  );
  const paintLegend = (): void => {
    const { range, every } = view.cloud;
    thinned.hidden = every === 1 || !store.cloud;
    thinned.textContent = `1 of ${every} points drawn`;
    depth.hidden = view.cloud.effective !== "depth" || !store.cloud;
    fill(depth, `${range.x.toFixed(2)} m`, ramp, `${range.y.toFixed(2)} m`);
  };
  store.watch(["cloud"], paintLegend);
  paintLegend();

  const card = byId("card");
  const paintCard = (): void => {
    const { object, grasp } = store.selection;
    card.hidden = object === null;
    if (object === null) return;
    const plan = store.plans.get(object);
    const rank = grasp ?? 0;
    const chosen = plan?.grasps[rank];
    const why = chosen ? app.whyNot(kExecuteService) : "";
    fill(
      card,
      el(
        "div",
        { class: "row" },
        el("strong", {}, chosen ? `Object ${object}, grasp ${rank + 1}` : `Object ${object}`),
        el(
          "button",
          { class: "plain", "data-key": "unselect", "aria-label": "Choose nothing", onclick: () => store.select(null) },
          "×",
        ),
      ),
      chosen
        ? el(
            "p",
            {},
            [
              chosen.generator,
              chosen.quality !== undefined ? `quality ${chosen.quality.toFixed(3)}` : "",
              chosen.success !== undefined ? `P(lift) ${Math.round(100 * chosen.success)} %` : "",
            ]
              .filter(Boolean)
              .join(" · "),
          )
        : el("p", { class: "problem" }, plan ? plan.problem || "There is no grasp." : "It is not planned on yet."),
      chosen
        ? el(
            "button",
            {
              class: "primary",
              "data-key": "execute",
              disabled: why !== "",
              onclick: () => void execute(app, object, grasp),
            },
            "Execute",
          )
        : null,
      why ? el("small", { class: "muted" }, why) : null,
    );
  };
  store.watch(["selection", "objects"], paintCard);
  app.connection.offersChanged.on(paintCard);

  viewport.onClick = (id, at) => {
    const [kind, object, rank] = id?.split("/") ?? [];
    if (object === undefined) store.select(null);
    else if (kind === "grasp" && /^\d+$/.test(rank ?? "")) store.select(Number(object), Number(rank));
    else store.select(Number(object), null, at);
  };
}
