#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/io_loop.h"

namespace prehend::graph {

class PublisherSide;

/// A node of this process, as its neighbours in it see it. What is posted to its loop runs only
/// while its publishers exist.
struct LocalNode {
  std::shared_ptr<IoLoop> loop;
  PublisherSide* publishers = nullptr;
  /// Calls back, in this node's loop, once its callbacks have run for all that the node `server`
  /// has handed over up to now.
  using Reply = std::function<void(msgs::graph::PeerMessage::DeliveryAnswer)>;
  std::function<void(const std::string& server, Reply reply)> when_delivered;
};

/// The nodes of this process that hand messages over by pointer, by instance. Thread-safe.
class LocalNodes {
 public:
  static LocalNodes& of_this_process() {
    static LocalNodes nodes;
    return nodes;
  }
  void add(const std::string& instance, LocalNode node) {
    const std::lock_guard lock(mutex_);
    nodes_[instance] = std::move(node);
  }
  void remove(const std::string& instance) {
    const std::lock_guard lock(mutex_);
    nodes_.erase(instance);
  }
  /// With a null loop when there is none.
  LocalNode find(const std::string& instance) const {
    const std::lock_guard lock(mutex_);
    const auto found = nodes_.find(instance);
    return found == nodes_.end() ? LocalNode() : found->second;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, LocalNode> nodes_;
};

}  // namespace prehend::graph
