#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace prehend::graph {

/// A subscriber's queue that a node's messages wait in until their callback runs.
struct ReaderQueue {
  std::string topic;
  std::size_t depth = 0;      ///< messages
  std::size_t max_bytes = 0;  ///< of the messages
};

/// The queues (but those of QoS::latest, which lose messages by intent) of all subscribers that had
/// joined.
using ReaderQueues = std::vector<ReaderQueue>;

}  // namespace prehend::graph
