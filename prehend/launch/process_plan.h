#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "prehend/launch/child_process.h"
#include "prehend/launch/launch_file.h"

namespace prehend::launch {

/// One process of a launch: a node's program, or the container with the nodes composed in it.
struct LaunchProcess {
  std::string name;  ///< of its only node, or what `compose:` says
  std::vector<const LaunchNode*> nodes;
  std::vector<std::string> command;  ///< executable first
  std::map<std::string, std::string> environment;
  ProcessorShare share;
  std::vector<std::string> after;  ///< nodes of other processes that have to be ready before
  bool required = false;
  Respawn respawn;
  std::optional<double> stop_time;  ///< [s] the longest of its nodes'; none: they say nothing
};

/// Throws LaunchError when nodes of one process contradict each other in what is the process' own
/// (host, required, respawn, environment, cpu_affinity, nice), when names of processes and nodes
/// clash, and when nodes wait for each other in a circle, which is named.
void check_processes(const LaunchGraph& graph);

/// What is to be started on `host` ("" when the graph has no hosts), in the file's order. Points
/// into `graph`. Throws LaunchError when an affinity names a CPU that this process may not use.
std::vector<LaunchProcess> processes_of(const LaunchGraph& graph, const std::string& host);

}  // namespace prehend::launch
