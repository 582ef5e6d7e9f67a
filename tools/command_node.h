#pragma once

#include <functional>
#include <string>

#include "prehend/graph/node.h"

namespace prehend::tools {

/// Runs `set_up` as a node of the graph with a name of its own; Ctrl-C shuts it down. Returns an
/// exit code, after printing what an exception that left `set_up` says.
int run_as_node(const std::string& name, const std::string& registry,
                const std::function<void(graph::Node&)>& set_up, bool simulated_clock = false);

/// How a command joins as a node that looks after its own end.
graph::NodeOptions command_node(const std::string& name, const std::string& registry);

/// Throws std::runtime_error, naming the nearest topic, when nobody publishes it.
void require_publisher(const std::string& registry, const std::string& topic);

}  // namespace prehend::tools
