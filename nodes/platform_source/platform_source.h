#pragma once

#include <string>

#include "prehend/graph/node.h"

namespace prehend::nodes {

/// Declares the parameter `platforms`: the folder of the platforms that have names, for
/// robot::platform_file().
std::string declare_platforms(graph::Node& node);

}  // namespace prehend::nodes
