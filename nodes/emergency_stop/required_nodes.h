#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "msgs/graph.pb.h"
#include "prehend/graph/introspection.h"

namespace prehend::nodes {

/// Looks after nodes without which nothing may move. The death of a process of this host is seen
/// within a millisecond (pidfd_open(2)); a node elsewhere, one that hangs, or that left while its
/// process lives, by what the registry has not heard for kSilence. A node that never came is not
/// lost. While the registry is away, or new and not yet told of everybody, only deaths are seen.
class RequiredNodes {
 public:
  /// Nodes beat once a second.
  static constexpr std::chrono::milliseconds kSilence{2500};

  struct Loss {
    std::string node, reason;
  };

  /// `names`: of nodes of the graph; one that does not exist is tried with `prefix` before it,
  /// as nodes of a namespace have. `registry`: endpoint; empty: PREHEND_REGISTRY, else the default.
  RequiredNodes(std::vector<std::string> names, std::string prefix,
                const std::string& registry = "");
  ~RequiredNodes();
  RequiredNodes(const RequiredNodes&) = delete;
  RequiredNodes& operator=(const RequiredNodes&) = delete;

  /// Waits for `patience` or until a node is lost, and returns those that were since the last call.
  /// One thread.
  std::vector<Loss> wait_for_losses(std::chrono::milliseconds patience);
  /// Those that were lost and are not back, in words; "": none. Any thread.
  std::string away() const;
  /// Those that never came, in words; "": none. Any thread.
  std::string missing() const;

  /// What the registry says, for tests: `records` are all nodes that it knows.
  void take(const std::vector<msgs::graph::NodeRecord>& records,
            std::chrono::steady_clock::time_point now);

 private:
  struct Required {
    enum class State { kNeverCame, kThere, kLost };
    std::string name;
    State state = State::kNeverCame;
    std::string instance;
    int process = -1;  // pidfd; -1: of another host, or ended
    std::chrono::steady_clock::time_point seen{};
  };

  void ask_registry();
  const msgs::graph::NodeRecord* record_of(
      const Required& required, const std::vector<msgs::graph::NodeRecord>& records) const;
  void lose(Required& required, const std::string& reason);
  std::string named(Required::State state) const;

  const std::string prefix_;
  graph::Introspection introspection_;  // of the thread
  int awake_ = -1;            // eventfd: there are other processes to look after, or losses
  mutable std::mutex mutex_;  // guards what follows
  std::vector<Required> required_;
  std::vector<Loss> losses_;
  bool ends_ = false;
  std::condition_variable end_;
  std::thread thread_;
};

}  // namespace prehend::nodes
