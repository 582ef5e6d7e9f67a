#include "drivers/ros/node/ros1_parameters.h"

#include <utility>

#include "drivers/ros/transport/roscpp_peer.h"

namespace prehend::drivers::ros_link {

Connect declare_roscpp(graph::Node& node, const std::string& ros_name) {
  const auto name = node.declare_parameter<std::string>({.name = "ros_name",
                                                         .default_value = ros_name,
                                                         .description = "of its node in ROS",
                                                         .read_only = true});
  const auto master = node.declare_parameter<std::string>(
      {.name = "master",
       .description = "URI of the ROS master; empty: ROS_MASTER_URI, else this machine's",
       .read_only = true});
  const auto patience = node.declare_parameter<double>({.name = "patience",
                                                        .default_value = 10,
                                                        .unit = "s",
                                                        .minimum = 0,
                                                        .maximum = 3600,
                                                        .description = "to wait for the master",
                                                        .read_only = true});
  return [name, master, patience](RosProblem tell) {
    return connect_roscpp(name, master, patience, std::move(tell));
  };
}

}  // namespace prehend::drivers::ros_link
