// The small world of the tests on a server of its own, as long as wanted: node tests/demo.mjs [PORT], to work at the
// page.

import { pathToFileURL } from "node:url";
import { TestServer } from "./server.mjs";
import * as world from "./world.mjs";

/** Adds all of the world to a server; `step(time)` then moves it. */
export function populate(server, { points = 9000, links = 8 } = {}) {
  const latch = (topic, type, data, keep = 1) => server.publish(topic, type, data, { latched: true, keep });
  const frames = (time) => latch("/viewer/frames", "foxglove.FrameTransforms", world.frames(time, links));
  frames(0);
  latch("/viewer/robot", "foxglove.SceneUpdate", world.robotUpdate(links));
  latch("/viewer/table", "foxglove.SceneUpdate", world.tableUpdate());
  latch("/viewer/objects", "foxglove.SceneUpdate", world.objectsUpdate());
  latch("/viewer/cloud", "foxglove.PointCloud", world.cloud(points));
  latch("/viewer/image/left", "foxglove.RawImage", world.picture());
  for (const object of [0, 1, 2]) latch("/plans", "prehend.msgs.GraspPlan", world.plan(object), 8);
  for (const data of world.diagnostics()) latch("/diagnostics", "prehend.msgs.graph.Diagnostic", data, 8);
  latch("/emergency_stop", "prehend.msgs.EmergencyStop", world.stopState(false));
  let spoken = 0;
  const done = { ok: true, message: "" };
  server.services.set(
    "/viewer/stop",
    () => (latch("/emergency_stop", "prehend.msgs.EmergencyStop", world.stopState(true)), done),
  );
  server.services.set(
    "/viewer/reset_stop",
    () => (latch("/emergency_stop", "prehend.msgs.EmergencyStop", world.stopState(false)), done),
  );
  server.services.set("/viewer/simulation", () => done);
  server.services.set("/viewer/execute", () => done);
  server.services.set("/viewer/describe_parameters", () => [
    {
      name: "grasp_cycle.grasp_force",
      type: "double",
      value: 12,
      min: 0,
      max: 100,
      description: "force of each pad on the object",
      unit: "N",
    },
    {
      name: "grasp_planning.generators",
      type: "string",
      value: "circles",
      choices: ["circles", "boxes", "antipodal"],
      description: "what makes candidates",
    },
    { name: "grasp_cycle.reacts", type: "bool", value: true, description: "stops the approach where the hand touches" },
  ]);
  server.parameters = [
    { name: "grasp_cycle.grasp_force", value: 12, type: "float64" },
    { name: "grasp_planning.generators", value: "circles" },
    { name: "grasp_cycle.reacts", value: true },
  ];
  return (time) => {
    server.sendTime(time);
    frames(time);
    for (const [topic, type, data] of world.signalsAt(time)) server.publish(topic, type, data, { time });
    for (const [begin, topic, type, data] of world.eventsUntil(time).slice(spoken)) {
      spoken++;
      server.publish(topic, type, data, { time: begin, latched: true, keep: 64 });
    }
  };
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href) {
  const server = new TestServer();
  const step = populate(server);
  const port = await server.start(Number(process.argv[2] ?? 0));
  console.log(`http://127.0.0.1:${port}/`);
  const begin = performance.now();
  setInterval(() => step((performance.now() - begin) / 1000), 33);
}
