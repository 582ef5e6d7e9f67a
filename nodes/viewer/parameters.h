#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "msgs/graph.pb.h"
#include "prehend/graph/introspection.h"
#include "prehend/viewing/hub.h"
#include "prehend/viewing/types.h"

namespace prehend::nodes {

/// "grasp_planning", "budget" -> "grasp_planning.budget"; nodes' names have no '.'.
std::string viewed_name(const std::string& node, const std::string& parameter);

/// A node's parameter as viewers have it, and its text as nodes take it.
viewing::Parameter viewed_parameter(const std::string& node,
                                    const msgs::graph::ParameterRecord& record);
/// @throws std::invalid_argument for a value that no parameter has.
std::string parameter_text(const viewing::Parameter& parameter);

/// The parameters of a graph's nodes, for viewers. Its functions wait for nodes (2 s each at most):
/// one thread at a time, and not one that others wait for.
class Parameters {
 public:
  /// As Introspection.
  Parameters(const std::string& registry, const std::string& keys_file);

  /// Those of these names, or all. A node that does not answer is left out, and said.
  viewing::ParameterAnswer get(const std::vector<std::string>& names);
  /// Sets each, and says what is in force then and what was refused.
  viewing::ParameterAnswer set(const std::vector<viewing::Parameter>& parameters);
  /// JSON: [{name, type, value, default, min, max, choices, unit, description, read_only}] of all.
  std::string described();

 private:
  graph::Introspection graph_;
};

}  // namespace prehend::nodes
