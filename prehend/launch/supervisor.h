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
  /// From SIGINT to SIGTERM when stopping, of nodes without a stop_time of their own.
  std::chrono::milliseconds interrupt_time{3000};
  std::chrono::milliseconds terminate_time{3000};  ///< from SIGTERM to SIGKILL
  /// After a second signal: from SIGINT to SIGKILL, of nodes without a stop_time of their own.
  std::chrono::milliseconds hurried_time{2000};
  std::chrono::milliseconds steady_time{30000};  ///< up for so long: the next delay is the first
};

/// Starts a registry and the processes of `graph` (of one host), those with `after:` once the nodes
/// they name are ready or have ended with exit code 0; shows and logs what they write, says when
/// they are ready, and keeps them running until
/// - SIGINT, SIGTERM or SIGHUP comes;
/// - a required process ends, and says why unless its exit code was 0. graph::kAnswerIsNo is an
///   answer, and becomes the launch's exit code;
/// - one that is not required fails before it was ever ready, if respawned five times in a row;
/// - all have ended.
/// Then all others are stopped: SIGINT, later SIGTERM, later SIGKILL. A second signal shortens that
/// to SIGKILL 2 s after the SIGINT; but a node that says how long it may take to end (stop_time: it
/// has something to write) has that time in any case. The last lines name every process that did
/// not end well, whenever that was.
/// Returns 0, or graph::kAnswerIsNo, when all that ran last ended well: with exit code 0, or, when
/// asked to stop, with an answer or by SIGINT itself. Else, and when one had to be killed, 1.
/// No child outlives the call, nor this process, however it ends.
/// Blocks those signals in the calling thread; call it before making threads.
/// Throws std::runtime_error when the registry or a program cannot be started.
int run_launch(const LaunchGraph& graph, const SupervisorOptions& options);

}  // namespace prehend::launch
