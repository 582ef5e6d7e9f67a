/** The emergency stop: always in view, by button, Escape or "!"; ended by an explicit click alone. */

import type { App } from "../app.js";
import { byId, el, fill } from "../dom.js";
import { clockText } from "../time.js";

export const kStopService = "/viewer/stop";
const kResetService = "/viewer/reset_stop";

export function stopPanel(app: App): void {
  const button = byId<HTMLButtonElement>("stop");
  const banner = byId("stop-banner");
  const { store, connection } = app;

  const stop = async (): Promise<void> => {
    const why = connection.state === "connected" ? app.whyNot(kStopService) : "this page is not connected";
    if (why !== "") {
      app.say(`NOT stopped: ${why}. Use the hardware's own stop, or prehend stop.`, "error", "stop");
      return;
    }
    button.classList.add("pressed");
    if (await app.request(kStopService, { reason: "stopped on the viewer's page" }))
      app.say("Stop was sent.", "warning", "stop");
    button.classList.remove("pressed");
  };
  button.addEventListener("click", () => void stop());
  window.addEventListener(
    "keydown",
    (event) => {
      const isTyping = event.target instanceof HTMLInputElement && /text|search/.test(event.target.type);
      if (event.repeat || !(event.key === "Escape" || (event.key === "!" && !isTyping))) return;
      event.preventDefault();
      void stop();
    },
    true,
  );

  const paint = (): void => {
    const isReachable = connection.state === "connected" && app.whyNot(kStopService) === "";
    button.classList.toggle("unreachable", !isReachable);
    button.title = isReachable
      ? "Stops all motion (Escape or !)"
      : "The emergency stop cannot be reached from this page now";
    const state = store.stop;
    banner.hidden = state?.stopped !== true;
    button.setAttribute("aria-pressed", String(state?.stopped === true));
    if (!state?.stopped) return;
    const where = app.isRecording() ? "In the recording, all" : "All";
    fill(
      banner,
      el("strong", {}, `${where} motion is stopped`),
      el(
        "span",
        {},
        `by ${state.source || "somebody"}: ${state.reason || "no reason given"} (since ${clockText(state.since)})`,
      ),
      app.isRecording()
        ? null
        : el(
            "button",
            {
              "data-key": "reset",
              disabled: app.whyNot(kResetService) !== "",
              title: app.whyNot(kResetService) || "Lets what moves move again",
              onclick: () => void app.request(kResetService, {}),
            },
            "Reset the stop",
          ),
    );
  };
  store.watch(["stop"], paint);
  connection.offersChanged.on(paint);
  connection.stateChanged.on(paint);
  paint();
}
