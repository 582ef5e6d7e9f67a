#pragma once

#include <functional>
#include <string>
#include <vector>

#include "prehend/graph/node.h"

namespace prehend::graph {

/// What the command line of a node's program asks for.
struct NodeCommandLine {
  NodeOptions options;
  bool wants_help = false;
  bool wants_description = false;  ///< --describe
  std::string help;                ///< of the options; the parameters are listed apart
};

/// `words`: without the program. Throws std::invalid_argument with one clear line.
NodeCommandLine read_node_command_line(const std::vector<std::string>& words,
                                       const NodeDescription& description);

/// What a node declares before anything else it does.
struct DescribedNode {
  std::vector<ParameterInfo> parameters;
  std::string failure;  ///< not empty: what ended it before all may have been declared
};

/// Runs `set_up` on a node that joins no graph, as far as its first call that needs one.
DescribedNode describe_node(const NodeOptions& options, const std::function<void(Node&)>& set_up);

/// Prints to stdout what `command` wants to know; false when it wants to run.
bool print_what_is_asked(const NodeCommandLine& command, const NodeDescription& description,
                         const std::function<void(Node&)>& set_up);

}  // namespace prehend::graph
