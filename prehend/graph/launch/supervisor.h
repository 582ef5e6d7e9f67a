#pragma once

#include <chrono>
#include <string>

#include "prehend/graph/launch/launch_file.h"

namespace prehend::graph::launch {

struct SupervisorOptions {
  /// Where the launch's own registry listens; empty: the default endpoint, or a free port of
  /// loopback when that is in use.
  std::string registry;
  std::string registry_program;                    ///< path of the registry's executable
  std::string log_folder;                          ///< one file per process
  std::chrono::milliseconds ready_timeout{30000};  ///< until nodes that are not ready are named
  std::chrono::milliseconds interrupt_time{3000};  ///< from SIGINT to SIGTERM when stopping
  std::chrono::milliseconds terminate_time{3000};  ///< from SIGTERM to SIGKILL
  std::chrono::milliseconds first_delay{500};      ///< before a respawn; doubles each time
  std::chrono::milliseconds longest_delay{10000};
  std::chrono::milliseconds steady_time{30000};  ///< up for so long: the next delay is the first
};

/// Starts a registry and the nodes of `graph`, shows and logs what they write, says when they are
/// ready, and keeps them running until
/// - SIGINT, SIGTERM or SIGHUP comes: returns 0;
/// - a required node ends: returns 0 if its exit code was 0, else 1 and says why;
/// - a node that is neither required nor respawned fails before it was ready: returns 1;
/// - all nodes have ended: returns 0 if all their exit codes were 0.
/// Then all others are stopped: SIGINT, later SIGTERM, later SIGKILL; a second SIGINT goes straight
/// to SIGKILL. No child outlives the call, nor this process, however it ends.
/// Blocks those signals in the calling thread; call it before making threads.
/// Throws std::runtime_error when the registry or a program cannot be started.
int run_launch(const LaunchGraph& graph, const SupervisorOptions& options);

}  // namespace prehend::graph::launch
