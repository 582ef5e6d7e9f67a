#pragma once

#include <string>
#include <vector>

namespace prehend::nodes {

/// A node's process on this host.
struct Process {
  std::string node;
  int pid = 0;
  double peak_memory = 0;  // bytes, largest resident set so far
  double cpu_time = 0;     // s, user and system
};

/// The processes of all nodes that the registry knows, as far as they run on this host. Empty when
/// the registry does not answer.
std::vector<Process> list_processes();

}  // namespace prehend::nodes
