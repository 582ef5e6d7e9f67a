#include "nodes/touch_fidelity/touch_fidelity.h"

#include "prehend/graph/node.h"

namespace prehend::nodes {

fidelity::TouchRequest declare_touch_request(graph::Node& node, const std::string& prefix,
                                             const std::string& what) {
  fidelity::TouchRequest request;
  request.front = node.declare_parameter<std::string>(
      {.name = prefix + "front",
       .default_value = "",
       .description = "measured speed-accuracy front to choose the steps of " + what +
                      " from by budget or tolerance; empty: config/fidelity/touch.yaml, of robots "
                      "of arm and hand touch_hand.yaml",
       .read_only = true,
       .reads_file = true});
  request.budget = node.declare_parameter<double>(
      {.name = prefix + "budget",
       .default_value = 0.0,
       .unit = "s/s",
       .minimum = 0.0,
       .description = "processor time for each simulated second of " + what +
                      ": the most accurate setting of the front that takes no more; 0: none asked "
                      "for",
       .read_only = true});
  request.tolerance = node.declare_parameter<double>(
      {.name = prefix + "tolerance",
       .default_value = 0.0,
       .minimum = 0.0,
       .description = "by how much the pads' images may differ from those of finer steps, root "
                      "mean square as a share of the largest sum of a pad: the fastest setting of "
                      "the front that keeps it; 0: none asked for",
       .read_only = true});
  if (!request.front.empty() && !request.is_asked()) {
    throw geometry::InputError("Parameter " + prefix + "front is given without " + prefix +
                                   "budget or " + prefix + "tolerance",
                               "Give one of them to choose by, or leave the front out");
  }
  return request;
}

}  // namespace prehend::nodes
