#include "nodes/arm_cycle/arm_cycle_node.h"
#include "prehend/graph/node_program.h"

namespace {

int run(prehend::graph::Node& node) {
  prehend::nodes::ArmCycleNode cycle(node);
  node.spin();
  return cycle.exit_code();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"arm_cycle",
     "Executes the best planned grasp with an arm and a hand: opens, reach, approach, close, lift, "
     "carry, place, open, retreat, along the plan's segments (/arm/follow, /hand/move); with "
     "reacts it closes where it touches. Publishes what was predicted against what was felt "
     "(/surprise), where it is (/cycle/state) and how it ended (/cycle/result). The service "
     "/cycle/start starts again on the newest plans. With exit_when_done it exits 0 on success, 2 "
     "on failure, 3 when nothing can be grasped."},
    run);

}  // namespace
