#include "drivers/ros/emulator/emulated_controller.h"
#include "drivers/ros/node/ros1_parameters.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;
using namespace prehend::drivers::ros_link;

void run(graph::Node& node) { run_emulated_controller(node, declare_roscpp(node, "emulated_arm")); }

const graph::RegisteredNodeProgram registered(
    {"ros1_arm_emulator",
     "A controller of ROS 1 whose arm is the simulated one: offers the action "
     "control_msgs/FollowJointTrajectory there by /world/arm/follow, and tells "
     "/world/joint_states, "
     "for the driver ros1_bridge of this graph or another."},
    run);

}  // namespace
