/** Whether the page hears the graph, and what the server says of itself. */

import type { App, Tone } from "../app.js";
import { byId, el, fill } from "../dom.js";

const kShown = 8000; // ms, of a message that asks for nothing
const kMostNotices = 4;

export function connectionPanel(app: App): void {
  const { connection } = app;
  const chip = byId("connection");
  let timer: ReturnType<typeof setInterval> | undefined;

  const paint = (): void => {
    clearInterval(timer);
    chip.dataset["state"] = app.isRecording() ? "recording" : connection.state;
    if (app.isRecording()) chip.textContent = "recording";
    else if (connection.state === "connected") chip.textContent = connection.serverName || "connected";
    else if (connection.state === "waiting") {
      const until = performance.now() + connection.nextTry * 1000;
      const count = (): void => {
        chip.textContent = `no connection, again in ${Math.max(0, (until - performance.now()) / 1000).toFixed(0)} s`;
      };
      count();
      timer = setInterval(count, 500);
    } else chip.textContent = connection.state === "closed" ? "not connected" : "connecting …";
    chip.title = connection.address;
  };
  connection.stateChanged.on(paint);
  window.addEventListener("viewer-mode", paint);
  const tones: Tone[] = ["info", "warning", "error"];
  connection.status.on((level, text, id) => app.say(text, tones[level] ?? "error", id || undefined));
  paint();
}

/** The corner where things are said; warnings and errors stay until they are closed. */
export function notices(): { say: App["say"]; take: (id: string) => void } {
  const place = byId("notices");
  const take = (id: string): void => {
    for (const old of place.querySelectorAll<HTMLElement>("[data-id]")) if (old.dataset["id"] === id) old.remove();
  };
  const say: App["say"] = (text, tone = "info", id = text) => {
    take(id);
    const notice = el("div", { class: `notice ${tone}`, role: tone === "error" ? "alert" : "status" });
    notice.dataset["id"] = id;
    fill(
      notice,
      el("span", {}, text),
      el("button", { class: "plain", "aria-label": "Close this message", onclick: () => notice.remove() }, "×"),
    );
    place.append(notice);
    while (place.childElementCount > kMostNotices) place.firstElementChild?.remove();
    if (tone !== "error") setTimeout(() => notice.remove(), kShown);
  };
  return { say, take };
}
