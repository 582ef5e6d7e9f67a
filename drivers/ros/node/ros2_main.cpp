#include "drivers/ros/node/bridge.h"
#include "drivers/ros/node/ros2_parameters.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;
using namespace prehend::drivers::ros_link;

void run(graph::Node& node) { run_bridge(node, ros::Version::kRos2, declare_dds(node)); }

const graph::RegisteredNodeProgram registered(
    {"ros2_bridge",
     "Exchanges topics with ROS 2 by plain DDS, without ROS: clouds, images, calibrations, joints, "
     "wrenches, frames, log and time both ways, an arm and a gripper whose drivers are ROS 2's, "
     "and the action prehend_msgs/Pick, as the file `mapping` says. Actions need servers and "
     "clients of ROS 2 that run with rmw_cyclonedds_cpp."},
    run);

}  // namespace
