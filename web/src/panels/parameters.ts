/** Parameters of all nodes, edited within their ranges; what is shown is what the node took. */

import type { App } from "../app.js";
import { el, panel } from "../dom.js";
import type { Parameter, ParameterValue } from "../protocol/frames.js";

const kDescribe = "/viewer/describe_parameters";
const kPatience = 60_000; // ms: every node is asked

interface Description {
  type: string;
  min?: number;
  max?: number;
  choices: string[];
  text: string;
  unit: string;
  isReadOnly: boolean;
}

interface Row {
  root: HTMLElement;
  show: (value: ParameterValue | undefined) => void;
  note: HTMLElement;
  asked: ParameterValue | undefined;
}

export function parametersPanel(app: App): HTMLElement {
  const { connection } = app;
  const { root, body, note } = panel("parameters", "Parameters", false);
  const empty = el("p", { class: "muted" }, "The server offers no parameters.");
  const search = el("input", {
    type: "search",
    placeholder: "node or name",
    "aria-label": "Search parameters",
    oninput: () => filter(),
  });
  const list = el("div", { class: "parameters" });
  body.append(search, empty, list);
  const descriptions = new Map<string, Description>();
  const values = new Map<string, Parameter>();
  const rows = new Map<string, Row>();

  const describe = async (): Promise<void> => {
    if (descriptions.size > 0 || app.whyNot(kDescribe) !== "") return;
    try {
      const answer = await connection.callJson(kDescribe, {}, kPatience);
      for (const given of Array.isArray(answer) ? answer : []) {
        const description = descriptionOf(given);
        if (description) descriptions.set(description.name, description);
      }
      build();
    } catch (error) {
      app.say(
        `Ranges of parameters are not known: ${error instanceof Error ? error.message : String(error)}`,
        "warning",
      );
    }
  };

  const build = (): void => {
    rows.clear();
    const nodes = new Map<string, HTMLElement[]>();
    for (const name of [...values.keys()].sort()) {
      const dot = name.indexOf("."); // nodes have none in their names, parameters may
      const [node, own] = dot > 0 ? [name.slice(0, dot), name.slice(dot + 1)] : ["", name];
      const row = makeRow(name, own);
      rows.set(name, row);
      nodes.set(node, [...(nodes.get(node) ?? []), row.root]);
    }
    list.replaceChildren(
      ...[...nodes].map(([node, own]) =>
        el("details", { class: "node" }, el("summary", {}, node || "parameters", el("small", {}, own.length)), ...own),
      ),
    );
    filter();
  };

  const makeRow = (name: string, own: string): Row => {
    const description = descriptions.get(name);
    const given = values.get(name);
    const remark = el("small", { class: "remark", role: "status" });
    const set = (value: ParameterValue): void => {
      row.asked = value;
      remark.textContent = "…";
      const type = given?.type ?? (description?.type === "double" ? "float64" : undefined);
      connection.setParameter({ name, value, ...(type !== undefined && { type }) });
    };
    const editor = makeEditor(own, given?.value, description, set, (text) => (remark.textContent = text));
    const row: Row = {
      root: el(
        "div",
        { class: "parameter", "data-name": name },
        el(
          "label",
          { title: description?.text ?? "" },
          el("span", {}, own, description?.unit ? el("small", {}, description.unit) : null),
          editor.element,
        ),
        remark,
        description?.text ? el("p", { class: "muted" }, description.text) : null,
      ),
      show: editor.show,
      note: remark,
      asked: undefined,
    };
    row.show(given?.value);
    return row;
  };

  const filter = (): void => {
    const words = search.value.toLowerCase();
    for (const [name, row] of rows) row.root.hidden = words !== "" && !name.toLowerCase().includes(words);
    for (const node of list.querySelectorAll<HTMLDetailsElement>(".node")) {
      node.hidden = node.querySelector(".parameter:not([hidden])") === null;
      if (words !== "") node.open = true;
    }
  };

  connection.parameters.on((parameters) => {
    let isNew = false;
    for (const parameter of parameters) {
      isNew ||= !values.has(parameter.name);
      if (values.size < 5000 || values.has(parameter.name)) values.set(parameter.name, parameter);
      const row = rows.get(parameter.name);
      if (!row) continue;
      row.show(parameter.value);
      if (row.asked === undefined) continue;
      const took = JSON.stringify(row.asked) === JSON.stringify(parameter.value);
      row.note.textContent = took ? "set" : "refused: it stays";
      row.note.classList.toggle("bad", !took);
      row.asked = undefined;
    }
    empty.hidden = values.size > 0;
    note.textContent = values.size > 0 ? `${values.size}` : "";
    if (isNew) build();
  });
  connection.offersChanged.on(() => {
    if (root.open) void describe();
  });
  root.addEventListener("toggle", () => {
    if (root.open) void describe();
  });
  connection.sessionChanged.on(() => {
    descriptions.clear();
    values.clear();
    build();
  });
  return root;
}

function descriptionOf(given: unknown): (Description & { name: string }) | null {
  if (typeof given !== "object" || given === null) return null;
  const from = given as Record<string, unknown>;
  if (typeof from["name"] !== "string") return null;
  const number = (key: string): number | undefined => (typeof from[key] === "number" ? from[key] : undefined);
  const text = (key: string): string => (typeof from[key] === "string" ? from[key] : "");
  const [min, max] = [number("min"), number("max")];
  return {
    name: from["name"],
    type: text("type"),
    ...(min !== undefined && { min }),
    ...(max !== undefined && { max }),
    choices: Array.isArray(from["choices"])
      ? from["choices"].filter((choice): choice is string => typeof choice === "string")
      : [],
    text: text("description"),
    unit: text("unit"),
    isReadOnly: from["read_only"] === true,
  };
}

interface Editor {
  element: HTMLElement;
  show: (value: ParameterValue | undefined) => void;
}

/** The field that fits the value: a box to tick, a list, a number with its range, or JSON of anything else. */
function makeEditor(
  name: string,
  value: ParameterValue | undefined,
  description: Description | undefined,
  set: (value: ParameterValue) => void,
  refuse: (why: string) => void,
): Editor {
  const disabled = description?.isReadOnly ?? false;
  if (typeof value === "boolean") {
    const box = el("input", { type: "checkbox", disabled, onchange: () => set(box.checked) });
    return { element: box, show: (now) => (box.checked = now === true) };
  }
  const choices = description?.choices ?? [];
  if (choices.length > 0 && typeof value === "string") {
    const select = el("select", { disabled, onchange: () => set(select.value) });
    select.append(...choices.map((choice) => el("option", { value: choice }, choice)));
    return { element: select, show: (now) => (select.value = String(now)) };
  }
  if (typeof value === "number") {
    const { min, max } = description ?? {};
    const isWhole = description?.type === "int" || description?.type === "int64";
    const field = el("input", {
      type: "number",
      step: isWhole ? 1 : "any",
      min,
      max,
      disabled,
      onchange: () => change(field),
    });
    const range =
      min !== undefined && max !== undefined
        ? el("input", {
            type: "range",
            min,
            max,
            step: isWhole ? 1 : (max - min) / 200,
            disabled,
            "aria-label": `${name}, range`,
            onchange: (event) => change(event.currentTarget as HTMLInputElement),
          })
        : null;
    const change = (from: HTMLInputElement): void => {
      const wanted = from.valueAsNumber;
      if (!Number.isFinite(wanted)) refuse("that is no number");
      else if ((min !== undefined && wanted < min) || (max !== undefined && wanted > max))
        refuse(`it has to be within ${min ?? "…"} and ${max ?? "…"}`);
      else set(wanted);
    };
    const show = (now: ParameterValue | undefined): void => {
      field.value = String(now);
      if (range) range.value = String(now);
    };
    return { element: el("span", { class: "number-field" }, range, field), show };
  }
  const isText = typeof value === "string";
  const field = el("input", { type: "text", disabled, spellcheck: "false", onchange: () => change() });
  const change = (): void => {
    if (isText) return set(field.value);
    try {
      set(JSON.parse(field.value) as ParameterValue);
    } catch {
      refuse("that is no JSON, as [1, 2]");
    }
  };
  return { element: field, show: (now) => (field.value = isText ? String(now ?? "") : JSON.stringify(now ?? null)) };
}
