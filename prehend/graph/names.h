#pragma once

#include <string>

namespace prehend::graph {

/// Checks a node name: letters, digits and '_', not starting with a digit.
/// Throws std::invalid_argument naming the fault.
void check_node_name(const std::string& name);

/// Checks a topic, service or action name: '/' before each part, parts of letters, digits and '_',
/// e.g. "/camera/left". Throws std::invalid_argument naming the fault.
void check_resource_name(const std::string& name);

/// Checks a namespace: "" for none, else as a resource name, e.g. "/left".
/// Throws std::invalid_argument naming the fault.
void check_name_space(const std::string& name_space);

/// True for the names that are the same in every namespace: /clock, /log, /diagnostics and
/// /statistics, and what lies below them.
bool is_global_name(const std::string& name);

/// "/left" and "/camera" give "/left/camera"; a global name stays as it is.
std::string in_name_space(const std::string& name_space, const std::string& name);

}  // namespace prehend::graph
