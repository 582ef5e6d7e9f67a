#include <string>
#include <vector>

#include "nodes/emergency_stop/emergency_stop_node.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;

void run(graph::Node& node) {
  const auto required = node.declare_parameter<std::vector<std::string>>(
      {.name = "required",
       .default_value = {},
       .description = "nodes without which nothing may move: that one of them ends, or is not "
                      "heard for 2.5 s, is an emergency stop",
       .read_only = true});
  const nodes::EmergencyStopNode emergency_stop(node, required);
  node.spin();
}

const graph::RegisteredNodeProgram registered(
    {"emergency_stop",
     "Stops all motion: on the service /emergency_stop/stop (prehend stop), when a required node "
     "is lost, and when a driver says that its device stopped by itself. Publishes "
     "/emergency_stop, to "
     "which every node that moves something listens, also for its silence. The stop stays until "
     "the service /emergency_stop/reset (prehend stop --reset), which is refused while its cause "
     "goes on."},
    run);

}  // namespace
