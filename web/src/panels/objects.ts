/** Objects, their grasps best first, and the ledger: what was tried, and why it failed. */

import type { App } from "../app.js";
import { el, fill, panel } from "../dom.js";
import type { GraspInfo, ObjectInfo, Plan, Rejection, Vector } from "../scene/types.js";
import { paletteColor } from "../view/ramp.js";

export const kExecuteService = "/viewer/execute";
const kFirstGrasps = 6;
const kFirstReasons = 6;

const percent = (share: number): string => `${Math.round(100 * share)} %`;

export function objectsPanel(app: App): HTMLElement {
  const { store } = app;
  const { root, body, note } = panel("objects", "Objects and grasps");
  const list = el("ul", { class: "objects" });
  const empty = el("p", { class: "muted" }, "Nothing has been segmented yet.");
  body.append(empty, list);
  let showsAll = false;

  const paint = (): void => {
    const ids = [...new Set([...store.objects.keys(), ...store.plans.keys()])].sort((a, b) => a - b);
    empty.hidden = ids.length > 0;
    const graspable = ids.filter((id) => (store.plans.get(id)?.grasps.length ?? 0) > 0).length;
    note.textContent = ids.length > 0 ? `${graspable} of ${ids.length} can be grasped` : "";
    fill(list, ...ids.map((id) => item(id)));
  };

  const item = (id: number): HTMLElement => {
    const info: ObjectInfo = store.objects.get(id) ?? { id, problem: "", details: [] };
    const plan = store.plans.get(id);
    const isSelected = store.selection.object === id;
    const swatch = el("span", { class: "swatch", "aria-hidden": "true" });
    const [red, green, blue] = paletteColor(id);
    swatch.style.background = `rgb(${255 * red} ${255 * green} ${255 * blue})`;
    const head = el(
      "button",
      {
        class: "object-head",
        "data-key": `object ${id}`,
        "aria-expanded": String(isSelected),
        onclick: () => {
          showsAll = false;
          store.select(isSelected ? null : id);
        },
      },
      swatch,
      el("span", { class: "object-name" }, `Object ${id}`, el("small", {}, info.known ?? info.method ?? "")),
      el("span", { class: `verdict ${verdictTone(plan)}` }, verdict(plan)),
    );
    const entry = el("li", { class: isSelected ? "selected" : "", "data-object": id }, head);
    if (isSelected) entry.append(facts(info), ...(plan ? [grasps(plan), ledger(plan, store.selection.at)] : []));
    return entry;
  };

  const grasps = (plan: Plan): HTMLElement => {
    if (plan.grasps.length === 0) return el("p", { class: "problem" }, plan.problem || "There is no grasp.");
    const shown = showsAll ? plan.grasps : plan.grasps.slice(0, kFirstGrasps);
    const most = Math.max(...plan.grasps.map((grasp) => grasp.quality ?? 0), 1e-9);
    const rows = shown.map((grasp) => graspRow(grasp, most));
    const more =
      plan.grasps.length > shown.length
        ? el(
            "button",
            { class: "plain", "data-key": "more", onclick: () => ((showsAll = true), paint()) },
            `all ${plan.grasps.length}`,
          )
        : null;
    return el(
      "div",
      {},
      el(
        "table",
        { class: "grasps" },
        el(
          "thead",
          {},
          el(
            "tr",
            {},
            el("th", { scope: "col" }, "#"),
            el(
              "th",
              { scope: "col", title: "Epsilon of the grasp wrench space: the least disturbance that breaks it" },
              "quality",
            ),
            el(
              "th",
              {
                scope: "col",
                title: "Probability that it is lifted; in brackets the share of disturbed cases it holds in",
              },
              "P(lift)",
            ),
            el("th", { scope: "col", title: "Share of the contact on surface that nobody saw" }, "guessed"),
            el("th", { scope: "col" }, ""),
          ),
        ),
        el("tbody", {}, ...rows),
      ),
      more,
    );
  };

  const graspRow = (grasp: GraspInfo, most: number): HTMLElement => {
    const { selection } = store;
    const isSelected = selection.object === grasp.object && selection.grasp === grasp.rank;
    const bar = el("meter", { min: 0, max: most, value: grasp.quality ?? 0, "aria-label": "quality" });
    const chance =
      grasp.success !== undefined
        ? percent(grasp.success)
        : grasp.robustness !== undefined
          ? `(${percent(grasp.robustness)})`
          : "–";
    const why = app.whyNot(kExecuteService);
    const select = (): void => store.select(grasp.object, isSelected ? null : grasp.rank);
    return el(
      "tr",
      { class: isSelected ? "selected" : "", title: [grasp.generator, grasp.remark].filter(Boolean).join(" · ") },
      el(
        "th",
        { scope: "row" },
        el(
          "button",
          {
            class: "plain rank",
            "data-key": `grasp ${grasp.rank}`,
            "aria-pressed": String(isSelected),
            onclick: select,
          },
          grasp.rank + 1,
        ),
      ),
      el("td", { onclick: select }, bar, el("span", { class: "number" }, grasp.quality?.toFixed(3) ?? "–")),
      el("td", { class: "number" }, chance),
      el("td", { class: "number" }, grasp.guessedContact !== undefined ? percent(grasp.guessedContact) : "–"),
      el(
        "td",
        {},
        el(
          "button",
          {
            class: "small",
            "data-key": `execute ${grasp.rank}`,
            "aria-label": `Execute grasp ${grasp.rank + 1} of object ${grasp.object}`,
            disabled: why !== "",
            title: why || "Approach, grasp and lift",
            onclick: () => void execute(app, grasp.object, grasp.rank),
          },
          "Execute",
        ),
      ),
    );
  };

  store.watch(["objects", "selection"], paint);
  app.connection.offersChanged.on(paint);
  store.watch(["selection"], () => list.querySelector(".selected")?.scrollIntoView({ block: "nearest" }));
  paint();
  return root;
}

/** Asks the cycle to grasp an object, with the grasp of this rank first; null: as its plan has it. */
export async function execute(app: App, object: number, grasp: number | null): Promise<void> {
  if (await app.request(kExecuteService, grasp === null ? { object } : { object, grasp })) {
    const what =
      grasp === null
        ? `Object ${object} is being grasped.`
        : `Grasp ${grasp + 1} of object ${object} is being executed.`;
    app.say(what, "info", "execute");
  }
}

function verdict(plan: Plan | undefined): string {
  if (!plan) return "planning …";
  const best = plan.grasps[0];
  if (!best) return plan.outcome === "failed" ? "not planned" : "no grasp";
  return best.success !== undefined ? `P ${percent(best.success)}` : `${plan.grasps.length} grasps`;
}

function verdictTone(plan: Plan | undefined): string {
  if (!plan) return "muted";
  return plan.grasps.length > 0 ? "good" : "bad";
}

function facts(info: ObjectInfo): HTMLElement {
  const rows: [string, string][] = [];
  if (info.confidence !== undefined) rows.push(["shape is right", percent(info.confidence)]);
  if (info.volume !== undefined) rows.push(["volume", `${(1e6 * info.volume).toFixed(0)} cm³`]);
  if (info.guessedArea !== undefined) rows.push(["guessed area", percent(info.guessedArea)]);
  for (const { name, value } of info.details) rows.push([name, value]);
  return el(
    "div",
    {},
    info.problem ? el("p", { class: "problem" }, info.problem) : null,
    el("dl", { class: "facts" }, ...rows.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)])),
  );
}

/** "Why not here?": reasons by how many candidates they cost, and how far the nearest was from passing. */
function ledger(plan: Plan, clicked: Vector | undefined): HTMLElement {
  const reasons = plan.rejections.slice(0, kFirstReasons);
  const rest = plan.rejections.slice(kFirstReasons).reduce((sum, rejection) => sum + rejection.count, 0);
  const most = Math.max(1, ...plan.rejections.map((rejection) => rejection.count));
  const row = (rejection: Rejection): HTMLElement =>
    el(
      "li",
      {},
      el("span", { class: "reason" }, rejection.reason),
      el("span", { class: "number" }, rejection.count),
      el("meter", { min: 0, max: most, value: rejection.count, "aria-hidden": "true" }),
      el(
        "small",
        {},
        [rejection.generator, rejection.nearestMiss && `nearest ${rejection.nearestMiss}`].filter(Boolean).join(": "),
      ),
    );
  const total = plan.candidates > 0 ? `${plan.candidates} candidates, ${plan.grasps.length} grasps` : "";
  return el(
    "section",
    { class: "ledger" },
    el("h3", {}, "Why not here?", el("small", {}, total)),
    clicked && nearestGrasp(plan, clicked),
    plan.problem && plan.grasps.length > 0 ? el("p", { class: "problem" }, plan.problem) : null,
    reasons.length === 0 ? el("p", { class: "muted" }, "Nothing was rejected.") : null,
    el(
      "ul",
      {},
      ...reasons.map(row),
      rest > 0 ? row({ reason: "other reasons", count: rest, generator: "", nearestMiss: "" }) : null,
    ),
    plan.remedies.length > 0 ? el("h4", {}, "It could be grasped") : null,
    el("ul", { class: "plain-list" }, ...plan.remedies.map((text) => el("li", {}, text))),
    plan.choices.length > 0 ? el("h4", {}, "Worth most first") : null,
    el("ol", { class: "plain-list" }, ...plan.choices.map((text) => el("li", {}, text))),
  );
}

/** Which grasp touches nearest to where the object was clicked. */
function nearestGrasp(plan: Plan, clicked: Vector): HTMLElement | null {
  const distance = (grasp: GraspInfo): number =>
    Math.min(...grasp.contacts.map((contact) => Math.hypot(...contact.map((value, i) => value - clicked[i]!))));
  const [nearest] = plan.grasps.filter((grasp) => grasp.contacts.length > 0).sort((a, b) => distance(a) - distance(b));
  if (!nearest) return null;
  return el(
    "p",
    {},
    `Where you clicked: grasp ${nearest.rank + 1} touches nearest, ${(1000 * distance(nearest)).toFixed(0)} mm away.`,
  );
}
