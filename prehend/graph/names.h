#pragma once

#include <string>

namespace prehend::graph {

/// Checks a node name: letters, digits and '_', not starting with a digit.
/// Throws std::invalid_argument naming the fault.
void check_node_name(const std::string& name);

/// Checks a topic, service or action name: '/' before each part, parts of letters, digits and '_',
/// e.g. "/camera/left". Throws std::invalid_argument naming the fault.
void check_resource_name(const std::string& name);

}  // namespace prehend::graph
