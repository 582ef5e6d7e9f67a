/** A recording from a file that was dropped on the page or chosen: where it is, how fast, to and fro. */

import type { App } from "../app.js";
import { byId, el } from "../dom.js";
import type { Player } from "../recording/player.js";
import { durationText } from "../time.js";

const kSpeeds = [0.1, 0.25, 0.5, 1, 2, 5, 10];

export function playbackPanel(
  app: App,
  open: (file: File) => Promise<void>,
  close: () => void,
): { show: (player: Player | null) => void } {
  const place = byId("playback");
  const input = byId<HTMLInputElement>("file");
  const drop = byId("drop");
  let player: Player | null = null;

  const play = el("button", { class: "play", onclick: () => player?.play(!player.playing) }, "Play");
  const slider = el("input", { type: "range", min: 0, step: "any", value: 0, "aria-label": "Time of the recording" });
  const time = el("output", { class: "number" });
  const speed = el("select", {
    "aria-label": "Speed of the replay",
    onchange: () => player && (player.speed = Number(speed.value)),
  });
  speed.append(...kSpeeds.map((value) => el("option", { value: String(value) }, `${value} ×`)));
  speed.value = "1";
  const name = el("span", { class: "file-name" });
  place.append(play, slider, time, speed, name, el("button", { onclick: close }, "Back to live"));
  let isDragging = false;
  slider.addEventListener("input", () => {
    isDragging = true;
    void player?.seek(slider.valueAsNumber);
    paintTime();
  });
  slider.addEventListener("change", () => (isDragging = false));

  const paintTime = (): void => {
    if (!player) return;
    const at = isDragging ? slider.valueAsNumber : player.position;
    time.textContent = `${durationText(at)} / ${durationText(player.duration)}`;
  };
  const paint = (): void => {
    if (!player) return;
    play.textContent = player.playing ? "Pause" : "Play";
    if (!isDragging) slider.value = String(player.position);
    slider.setAttribute("aria-valuetext", durationText(player.position));
    paintTime();
  };

  const take = async (file: File | undefined): Promise<void> => {
    if (!file) return;
    try {
      await open(file);
    } catch (error) {
      app.say(
        `${file.name} cannot be shown: ${error instanceof Error ? error.message : String(error)}`,
        "error",
        "file",
      );
    }
  };
  byId("open").addEventListener("click", () => input.click());
  input.addEventListener("change", () => {
    void take(input.files?.[0]);
    input.value = "";
  });
  let depth = 0; // of elements that the pointer has entered
  const carriesFile = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
  window.addEventListener("dragenter", (event) => {
    if (!carriesFile(event)) return;
    depth++;
    drop.hidden = false;
  });
  window.addEventListener("dragleave", () => {
    depth = Math.max(0, depth - 1);
    drop.hidden = depth === 0;
  });
  window.addEventListener("dragover", (event) => event.preventDefault());
  window.addEventListener("drop", (event) => {
    event.preventDefault();
    depth = 0;
    drop.hidden = true;
    void take(event.dataTransfer?.files[0]);
  });

  return {
    show: (next) => {
      player = next;
      place.hidden = next === null;
      if (!next) return;
      slider.max = String(next.duration);
      name.textContent = next.name;
      name.title = `${next.topicCount} topics are shown${next.recording.problem ? `; ${next.recording.problem}` : ""}`;
      next.speed = Number(speed.value);
      next.changed.on(paint);
      paint();
    },
  };
}
