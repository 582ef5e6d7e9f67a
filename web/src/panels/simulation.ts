/** Simulated time: pause, step, speed, where the graph has a clock that can be told. */

import type { App } from "../app.js";
import { byId, el } from "../dom.js";
import { clockText } from "../time.js";

const kService = "/viewer/simulation";
const kSpeeds = [0.1, 0.25, 0.5, 1, 2, 5];

export function simulationPanel(app: App): void {
  const { store, connection } = app;
  const place = byId("simulation");
  const clock = byId("clock");
  let isPaused = false;

  const pause = el("button", { "aria-label": "Pause simulated time", onclick: () => void toggle() }, "Pause");
  const step = el(
    "button",
    { title: "Goes on by 50 ms and pauses again", onclick: () => void app.request(kService, { step: 0.05 }) },
    "Step",
  );
  const speed = el("select", { "aria-label": "Speed of simulated time", onchange: () => void setSpeed() });
  speed.append(
    ...kSpeeds.map((value) => el("option", { value: String(value) }, `${value} ×`)),
    el("option", { value: "0" }, "fastest"),
  );
  speed.value = "1";
  place.append(pause, step, speed);

  const toggle = async (): Promise<void> => {
    const wanted = !isPaused;
    if (await app.request(kService, { pause: wanted })) isPaused = wanted;
    paint();
  };
  const setSpeed = async (): Promise<void> => {
    await app.request(kService, { speed: Number(speed.value) });
  };
  const paint = (): void => {
    const why = app.whyNot(kService);
    place.hidden = why !== "" || app.isRecording();
    pause.textContent = isPaused ? "Go on" : "Pause";
    pause.setAttribute("aria-label", isPaused ? "Let simulated time go on" : "Pause simulated time");
    step.disabled = !isPaused;
    clock.textContent = clockText(store.time);
  };
  store.watch(["clock"], () => {
    if (Number.isFinite(store.speed)) isPaused = store.speed === 0;
    paint();
  });
  connection.offersChanged.on(paint);
  connection.sessionChanged.on(() => (isPaused = false));
  window.addEventListener("viewer-mode", paint);
  paint();
}
