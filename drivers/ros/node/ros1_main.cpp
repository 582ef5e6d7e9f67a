#include "drivers/ros/node/bridge.h"
#include "drivers/ros/node/ros1_parameters.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;
using namespace prehend::drivers::ros_link;

void run(graph::Node& node) {
  run_bridge(node, ros::Version::kRos1, declare_roscpp(node, "prehend"));
}

const graph::RegisteredNodeProgram registered(
    {"ros1_bridge",
     "Exchanges topics with ROS 1 by roscpp: clouds, images, calibrations, joints, wrenches, "
     "frames, log and time both ways, an arm and a gripper whose drivers are ROS's, and the action "
     "prehend_msgs/Pick, as the file `mapping` says."},
    run);

}  // namespace
