#pragma once

#include <chrono>
#include <string>

#include "prehend/launch/launch_file.h"

namespace prehend::launch {

struct SupervisorOptions {
  /// Of the graph's hosts, the one whose nodes are started; "" when it has none.
  std::string host;
  /// Where the launch's own registry listens; empty: the default endpoint, or a free port of
  /// loopback when that is in use. With `join_registry`: where another host's listens.
  std::string registry;
  bool join_registry = false;                         ///< start no registry of its own
  std::string registry_program;                       ///< path of the registry's executable
  std::string log_folder;                             ///< one file per process
  std::chrono::milliseconds registry_timeout{60000};  ///< until another host's answers
  std::chrono::milliseconds ready_timeout{30000};     ///< until nodes that are not ready are named
  std::chrono::milliseconds interrupt_time{3000};     ///< from SIGINT to SIGTERM when stopping
  std::chrono::milliseconds terminate_time{3000};     ///< from SIGTERM to SIGKILL
  std::chrono::milliseconds steady_time{30000};  ///< up for so long: the next delay is the first
};

/// Starts a registry and the processes of `graph` (of one host), those with `after:` once the nodes
/// they name are ready or have ended with exit code 0; shows and logs what they write, says when
/// they are ready, and keeps them running until
/// - SIGINT, SIGTERM or SIGHUP comes: returns 0;
/// - a required process ends: returns 0 if its exit code was 0, else 1 and says why;
/// - one that is not required fails before it was ever ready, if respawned five times in a row:
///   returns 1;
/// - all have ended: returns 0 if all their exit codes were 0.
/// Then all others are stopped: SIGINT, later SIGTERM, later SIGKILL; a second SIGINT goes straight
/// to SIGKILL. No child outlives the call, nor this process, however it ends.
/// Blocks those signals in the calling thread; call it before making threads.
/// Throws std::runtime_error when the registry or a program cannot be started.
int run_launch(const LaunchGraph& graph, const SupervisorOptions& options);

}  // namespace prehend::launch
