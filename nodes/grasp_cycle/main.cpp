#include "nodes/grasp_cycle/cycle_node.h"
#include "prehend/graph/node_program.h"

namespace {

int run(prehend::graph::Node& node) {
  prehend::nodes::CycleNode cycle(node);
  node.spin();
  return cycle.exit_code();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"grasp_cycle",
     "Executes the best planned grasp until one succeeds, and looks again after a failed attempt: "
     "with a parallel gripper on its carrier (/carrier/move, /gripper/move, /gripper/command) by "
     "touch, or with a platform's arm and hand (/arm/follow, /hand/move) along the plan's "
     "segments. "
     "Publishes what was predicted against what was felt (/surprise), where it is (/cycle/state) "
     "and how it ended (/cycle/result). The service /cycle/start starts again on the newest plans. "
     "With exit_when_done it exits 0 on success, 2 on failure, 3 when nothing can be grasped."},
    run);

}  // namespace
