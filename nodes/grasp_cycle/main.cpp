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
     "moves a platform's arm (/arm/follow) along the plan's segments, and its hand (/hand/move), "
     "or "
     "a parallel gripper by the touch of its pads (/gripper/move, /gripper/command). "
     "Publishes what was predicted against what was felt (/surprise), where it is (/cycle/state) "
     "and how it ended (/cycle/result). The service /cycle/start starts again on the newest plans, "
     "/cycle/stop stops all motion and ends the cycle as failed. "
     "With exit_when_done it exits 0 on success, 2 on failure, 3 when nothing can be grasped."},
    run);

}  // namespace
