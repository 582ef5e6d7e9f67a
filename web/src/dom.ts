/** Elements without markup in text: nothing that came over the wire is ever read as HTML. */

type Child = Node | string | number | null | false | undefined;
type Attributes = { [name: string]: string | number | boolean | ((event: Event) => void) | undefined };

/**
 * `el("button", { class: "small", onclick: run, disabled: true }, "Run")`; a false or undefined attribute is not set.
 */
export function el<Name extends keyof HTMLElementTagNameMap>(
  name: Name,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[Name] {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(key.slice(2), value);
    else if (value !== undefined && value !== false) element.setAttribute(key, value === true ? "" : String(value));
  }
  for (const child of children) {
    if (child !== null && child !== false && child !== undefined)
      element.append(typeof child === "number" ? String(child) : child);
  }
  return element;
}

/** The element of the page with this id. Throws an Error when index.html has none. */
export function byId<Kind extends HTMLElement = HTMLElement>(id: string): Kind {
  const element = document.getElementById(id);
  if (!element) throw new Error(`index.html has no #${id}`);
  return element as Kind;
}

/** Replaces what is in `parent`; what has the same data-key as the focused element before is focused again. */
export function fill(parent: HTMLElement, ...children: Child[]): void {
  const active = document.activeElement;
  const key = active instanceof HTMLElement && parent.contains(active) ? active.dataset["key"] : undefined;
  const top = parent.scrollTop;
  parent.replaceChildren(
    ...children.filter((child): child is Node | string => child instanceof Node || typeof child === "string"),
  );
  parent.scrollTop = top;
  if (key !== undefined) {
    for (const element of parent.querySelectorAll<HTMLElement>("[data-key]")) {
      if (element.dataset["key"] === key) {
        element.focus({ preventScroll: true });
        break;
      }
    }
  }
}

/** A panel of the side with its heading; `body` is where its content goes. */
export function panel(
  id: string,
  title: string,
  isOpen = true,
): { root: HTMLDetailsElement; body: HTMLElement; note: HTMLElement } {
  const body = el("div", { class: "panel-body" });
  const note = el("span", { class: "panel-note" });
  const root = el("details", { class: "panel", id, open: isOpen }, el("summary", {}, el("h2", {}, title), note), body);
  return { root, body, note };
}

const colors = new Map<string, string>(); // of the theme of the moment

/** A colour of the style sheet as the browser computes it for the theme of the moment: "rgb(1, 2, 3)". */
export function cssColor(name: string): string {
  const known = colors.get(name);
  if (known !== undefined) return known;
  const probe = byId("color-probe");
  probe.style.color = `var(${name})`;
  const color = getComputedStyle(probe).color;
  colors.set(name, color);
  return color;
}

/** The theme is another one. */
export function forgetColors(): void {
  colors.clear();
}
