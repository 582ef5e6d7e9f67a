/** Light and dark: as the system has it, until the switch is used. */

import { byId, forgetColors } from "./dom.js";

const kKey = "prehend-theme";

export function themeSwitch(): void {
  const button = byId("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  const isDark = (): boolean =>
    (document.documentElement.dataset["theme"] ?? (system.matches ? "dark" : "light")) === "dark";
  const paint = (): void => {
    button.setAttribute("aria-pressed", String(isDark()));
    button.textContent = isDark() ? "Light" : "Dark";
    button.setAttribute("aria-label", isDark() ? "Light colours" : "Dark colours");
    forgetColors();
    window.dispatchEvent(new Event("theme"));
  };
  let saved: string | null = null;
  try {
    saved = localStorage.getItem(kKey);
  } catch {
    // a browser that keeps nothing: as the system has it
  }
  if (saved === "dark" || saved === "light") document.documentElement.dataset["theme"] = saved;
  button.addEventListener("click", () => {
    const theme = isDark() ? "light" : "dark";
    document.documentElement.dataset["theme"] = theme;
    try {
      localStorage.setItem(kKey, theme);
    } catch {
      // not kept
    }
    paint();
  });
  system.addEventListener("change", paint);
  paint();
}
