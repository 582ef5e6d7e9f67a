#include "drivers/ros/node/ros2_parameters.h"

#include <cstdlib>
#include <utility>

#include "drivers/ros/transport/dds_peer.h"

namespace prehend::drivers::ros_link {
namespace {

int environment_domain() {
  const char* text = std::getenv("ROS_DOMAIN_ID");
  return text ? std::atoi(text) : 0;
}

}  // namespace

Connect declare_dds(graph::Node& node) {
  DdsOptions options;
  options.domain = node.declare_parameter<int>(
      {.name = "domain",
       .default_value = -1,
       .minimum = -1,
       .maximum = 232,
       .description = "of DDS, as ROS_DOMAIN_ID; -1: as that says, else 0",
       .read_only = true});
  if (options.domain < 0) options.domain = environment_domain();
  options.network = node.declare_parameter<std::string>(
      {.name = "network",
       .default_value = options.network,
       .description =
           "loopback: this machine alone; environment: as CYCLONEDDS_URI says; else name "
           "or address of the network's interface",
       .read_only = true});
  return [options](RosProblem tell) { return connect_dds(options, std::move(tell)); };
}

}  // namespace prehend::drivers::ros_link
