#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace prehend::graph {

struct RegistryOptions {
  /// ZeroMQ endpoint to listen on; tcp://127.0.0.1:* takes a free port.
  std::string endpoint = "tcp://127.0.0.1:11411";
  /// Of create_graph_keys; empty: PREHEND_KEYS, else no keys, and then only loopback is allowed.
  std::string keys_file{};
  /// A node that is silent for this long is gone. Nodes beat every second.
  std::chrono::milliseconds lease{3000};
};

/// The registry of one graph: which nodes live, what they publish, subscribe and serve, and their
/// message types. It only introduces nodes to each other; messages never pass through it, and they
/// keep flowing when it dies. Nodes register again with one that takes its place.
///
/// It makes the folder for the nodes' ipc sockets, prehend-PID-XXXXXX in XDG_RUNTIME_DIR or /tmp,
/// and removes it at the end; sockets of dead processes are removed at start.
class Registry {
 public:
  /// Listens and serves in a thread of its own. Throws std::runtime_error naming the mend when the
  /// endpoint is in use or malformed, or beyond loopback without keys.
  explicit Registry(RegistryOptions options = {});
  ~Registry();

  /// The endpoint nodes connect to, with the real port.
  const std::string& endpoint() const;
  const std::string& runtime_folder() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace prehend::graph
