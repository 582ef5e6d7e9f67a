#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "prehend/graph/introspection.h"
#include "prehend/launch/launch_output.h"
#include "prehend/launch/process_plan.h"

namespace prehend::launch {

/// What the registry says about which nodes are ready.
class Readiness {
 public:
  explicit Readiness(const std::string& registry);

  /// Asks the registry; false when it does not answer just now.
  bool ask();
  /// All nodes of the process are ready, as part of the process `pid`.
  bool is_ready(const LaunchProcess& process, pid_t pid) const;
  /// A node of that name is ready, on whatever host.
  bool is_ready(const std::string& node) const;
  /// Warns of remaps of names that the node does not use.
  void check_remaps(const LaunchNode& node, LaunchOutput& output) const;

 private:
  graph::Introspection introspection_;
  std::vector<msgs::graph::NodeRecord> records_;
};

}  // namespace prehend::launch
