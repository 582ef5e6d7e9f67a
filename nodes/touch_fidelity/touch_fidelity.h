#pragma once

#include <string>

#include "prehend/fidelity/touch_choice.h"

namespace prehend::graph {
class Node;
}

// The parameters of the nodes that simulate what pads feel.
namespace prehend::nodes {

/// Declares `front`, `budget` and `tolerance`, each with `prefix` before it.
/// @param what is simulated, for the descriptions: "the world".
fidelity::TouchRequest declare_touch_request(graph::Node& node, const std::string& prefix,
                                             const std::string& what);

}  // namespace prehend::nodes
