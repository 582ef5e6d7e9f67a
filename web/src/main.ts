/** The page: a store that a live connection or a recording fills, and the panels that show it. */

import { serverAddress } from "./address.js";
import type { App } from "./app.js";
import { byId, cssColor } from "./dom.js";
import { connectionPanel, notices } from "./panels/connection.js";
import { diagnosticsPanel, logPanel } from "./panels/health.js";
import { objectsPanel } from "./panels/objects.js";
import { parametersPanel } from "./panels/parameters.js";
import { picturesPanel } from "./panels/pictures.js";
import { playbackPanel } from "./panels/playback.js";
import { signalsPanel } from "./panels/signals.js";
import { simulationPanel } from "./panels/simulation.js";
import { stagePanel } from "./panels/stage.js";
import { stopPanel } from "./panels/stop.js";
import { surprisesPanel, timeline } from "./panels/timeline.js";
import { touchPanel } from "./panels/touch.js";
import { Connection } from "./protocol/connection.js";
import { base64Bytes } from "./protocol/frames.js";
import { Player } from "./recording/player.js";
import { openRecording } from "./recording/recording.js";
import { Ingest, isPicture, isShown } from "./scene/ingest.js";
import { Store } from "./scene/store.js";
import { themeSwitch } from "./theme.js";
import { seconds } from "./time.js";
import { Viewport } from "./view/viewport.js";

const store = new Store();
const ingest = new Ingest(store);
let player: Player | null = null;

let address = "";
const { say, take } = notices();
try {
  address = serverAddress(new URL(location.href));
} catch {
  say(`?ws= of this page's address is no address: give one as ws://127.0.0.1:8765`, "error");
}
const pictures = picturesPanel(store, (text, id) => say(text, "warning", id));
const connection = new Connection(address, (channel, all) => {
  if (player !== null || !isShown(channel, all.values())) return false;
  return pictures.root.open || !isPicture(channel);
});

const app: App = {
  store,
  connection,
  say,
  isRecording: () => player !== null,
  whyNot: (service) => {
    if (player !== null && service !== "/viewer/stop") return "a recording is shown";
    if (connection.state !== "connected") return "not connected";
    return connection.services.has(service) ? "" : "nothing that runs offers this";
  },
  request: async (service, body) => {
    try {
      const answer = await connection.callJson(service, body);
      const { ok, message } = (answer ?? {}) as { ok?: unknown; message?: unknown };
      if (ok === true) return true;
      say(
        `Refused: ${typeof message === "string" && message !== "" ? message : "the server does not say why"}`,
        "error",
        service,
      );
    } catch (error) {
      say(error instanceof Error ? error.message : String(error), "error", service);
    }
    return false;
  },
};

ingest.onTrouble = (text) => say(text, "warning");
connection.trouble.on((text) => say(`The server sent what is not understood: ${text}`, "warning", "protocol"));
connection.statusRemoved.on(take);
connection.sessionChanged.on(() => {
  if (player) return;
  ingest.reset();
  store.reset();
});
connection.time.on((time) => {
  if (player) return;
  store.time = seconds(time);
  store.touch("clock");
});
connection.message.on((channel, time, data) => {
  if (!player)
    ingest.take(`live ${channel.id} ${channel.schemaName}`, channel, () => base64Bytes(channel.schema), time, data);
});

function setPlayer(next: Player | null): void {
  player?.close();
  player = next;
  ingest.reset();
  store.reset();
  store.select(null);
  playback.show(next);
  connection.refresh(); // latched topics are sent again once they are subscribed to
  window.dispatchEvent(new Event("viewer-mode"));
  connection.offersChanged.emit();
}

const playback = playbackPanel(
  app,
  async (file) => {
    const recording = await openRecording(file);
    const next = new Player(file.name, recording, store, ingest);
    if (next.topicCount === 0) throw new Error("none of its topics is of a type that this page shows");
    setPlayer(next);
    next.trouble.on((text) => say(text, "error", "file"));
    if (recording.problem) say(`${file.name}: ${recording.problem}`, "warning", "file");
    await next.seek(0);
    next.play(true);
  },
  () => setPlayer(null),
);

pictures.root.addEventListener("toggle", () => connection.refresh());

themeSwitch();
stopPanel(app);
connectionPanel(app);
simulationPanel(app);
signalsPanel(app);
timeline(app);
byId("side").append(
  objectsPanel(app),
  touchPanel(app),
  surprisesPanel(app),
  pictures.root,
  diagnosticsPanel(app),
  parametersPanel(app),
  logPanel(app),
);

try {
  const viewport = new Viewport(byId<HTMLCanvasElement>("view"), store);
  const paint = (): void =>
    viewport.setTheme(
      cssColor("--stage"),
      cssColor("--stage-grid"),
      byId("theme").getAttribute("aria-pressed") === "true",
    );
  window.addEventListener("theme", paint);
  paint();
  viewport.view.onTrouble = (text) => say(text, "warning");
  stagePanel(app, viewport);
  // What tests and measurements look at.
  Object.assign(window, { prehend: { store, connection, viewport, player: () => player } });
} catch (error) {
  byId("no-view").hidden = false;
  say(`The 3-D view needs WebGL, which this browser does not give: ${String(error)}`, "error", "webgl");
}

if (address !== "") connection.open();
