#pragma once

#include <cstddef>

#include "prehend/graph/clock_pacer.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// Back-pressure for a simulation that does not wait for the wall clock (speed 0): lets no more
/// slices out than fit into every subscriber's queue, then waits until the subscribers' callbacks
/// have run for all of them. So only a subscriber that asks for `latest` misses messages; how fast
/// it goes is up to the slowest callback. At any other speed it does nothing.
class ReaderPace {
 public:
  ReaderPace(graph::Node& node, const graph::ClockPacer& pacer) : node_(node), pacer_(pacer) {}

  /// To be called in one thread after each slice, whose messages are at most one a topic. Returns
  /// early when the node was shut down or another speed was set. When subscribers take more than
  /// 2 s for what they have, that is reported.
  void slice_published();

 private:
  bool is_unbounded() const;

  graph::Node& node_;
  const graph::ClockPacer& pacer_;
  std::size_t slices_ = 0;       // since the subscribers had everything
  std::size_t most_slices_ = 1;  // that may be on the way
};

}  // namespace prehend::nodes
