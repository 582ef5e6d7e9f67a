#include "drivers/ros/emulator/emulated_controller.h"
#include "drivers/ros/node/ros2_parameters.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;
using namespace prehend::drivers::ros_link;

void run(graph::Node& node) { run_emulated_controller(node, declare_dds(node)); }

const graph::RegisteredNodeProgram registered(
    {"ros2_arm_emulator",
     "A controller of ROS 2 whose arm is the simulated one: offers the action "
     "control_msgs/FollowJointTrajectory there by /world/arm/follow, and tells "
     "/world/joint_states, "
     "for the driver ros2_bridge of this graph or another."},
    run);

}  // namespace
