#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "prehend/graph/delivery.h"
#include "prehend/graph/node.h"

namespace prehend {

/// Back-pressure for a replay that does not wait for the wall clock: lets as many messages out as
/// fit into every subscriber's queue, then waits until the subscribers' callbacks have run for all
/// of them. So nobody loses a message but who asked for `latest`; how fast it goes is up to the
/// slowest callback.
class DeliveryWindow {
 public:
  explicit DeliveryWindow(graph::Node& node) : node_(node) {}

  /// Waits until a message of `bytes` on the publisher's topic has room. False when the node was
  /// shut down. When subscribers take more than 2 s for what they have, that is reported.
  bool admit(const graph::RawPublisher& publisher, std::size_t bytes);

 private:
  struct Topic {
    std::size_t readers = 0;  // when asked last
    std::size_t depth = 0;    // of the smallest queue, 0: there is none
    std::size_t sent = 0;     // messages since then
  };
  bool has_room(const graph::RawPublisher& publisher, std::size_t bytes);
  bool wait_until_delivered();
  void take(const graph::ReaderQueues& queues);

  graph::Node& node_;
  std::map<std::string, Topic> topics_;
  std::size_t most_bytes_ = 0;  // that may be on the way, 0: not asked yet
  std::size_t bytes_ = 0;       // on the way
  std::size_t messages_ = 0;    // on the way
};

}  // namespace prehend
