/** What nodes say of their health, and the log. */

import type { App } from "../app.js";
import { el, fill, panel } from "../dom.js";
import { clockText } from "../time.js";
import type { Level } from "../scene/types.js";

const kOrder = { error: 0, warning: 1, ok: 2 };
const kLevels: Level[] = ["debug", "info", "warning", "error"];
const kMostLines = 200;

export function diagnosticsPanel(app: App): HTMLElement {
  const { store } = app;
  const { root, body, note } = panel("diagnostics", "Diagnostics");
  const list = el("ul", { class: "diagnostics" });
  const empty = el("p", { class: "muted" }, "No node has said anything of its health.");
  body.append(empty, list);
  store.watch(["diagnostics"], () => {
    const all = [...store.diagnostics.values()].sort(
      (a, b) => kOrder[a.level] - kOrder[b.level] || a.node.localeCompare(b.node),
    );
    empty.hidden = all.length > 0;
    const bad = all.filter((one) => one.level !== "ok").length;
    note.textContent = all.length === 0 ? "" : bad === 0 ? "all well" : `${bad} of ${all.length} complain`;
    note.classList.toggle("bad", bad > 0);
    fill(
      list,
      ...all.map((one) =>
        el(
          "li",
          { class: one.level },
          el("span", { class: "badge" }, one.level),
          el("strong", {}, one.node),
          el("span", {}, one.text),
        ),
      ),
    );
  });
  return root;
}

export function logPanel(app: App): HTMLElement {
  const { store } = app;
  const { root, body } = panel("log", "Log", false);
  const least = el("select", { "aria-label": "Least level that is shown", onchange: () => paint() });
  least.append(
    ...kLevels.map((level) => el("option", { value: level }, level === "debug" ? "all" : `${level} and worse`)),
  );
  least.value = "info";
  const search = el("input", {
    type: "search",
    placeholder: "node or text",
    "aria-label": "Search the log",
    oninput: () => paint(),
  });
  const list = el("ol", { class: "log", tabindex: 0, "aria-label": "Log, newest first" });
  body.append(el("div", { class: "row" }, least, search), list);
  const paint = (): void => {
    if (!root.open) return;
    const from = kLevels.indexOf(least.value as Level);
    const words = search.value.toLowerCase();
    const lines = store.log
      .filter((line) => kLevels.indexOf(line.level) >= from)
      .filter((line) => words === "" || `${line.node} ${line.text}`.toLowerCase().includes(words));
    fill(
      list,
      ...lines
        .slice(-kMostLines)
        .reverse()
        .map((line) =>
          el(
            "li",
            { class: line.level },
            el("time", {}, clockText(line.time)),
            el("strong", {}, line.node),
            el("span", {}, line.text),
          ),
        ),
    );
  };
  store.watch(["log"], paint);
  root.addEventListener("toggle", paint);
  return root;
}
