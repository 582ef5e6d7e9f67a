#include "nodes/simulation/reader_pace.h"

#include <algorithm>
#include <chrono>

namespace prehend::nodes {
namespace {

// So few that the connection takes all of them at once: what waits for it in the publisher is kept
// by the topic's own depth, and that may be 1.
constexpr std::size_t kMostSlices = 3;
constexpr auto kLook = std::chrono::milliseconds(500);  // whether another speed was set
constexpr int kPatience = 4;                            // looks before it is reported

}  // namespace

bool ReaderPace::is_unbounded() const { return pacer_.state().speed <= 0; }

void ReaderPace::slice_published() {
  if (!is_unbounded()) {
    slices_ = 0;
    most_slices_ = 1;
    return;
  }
  if (++slices_ < most_slices_) return;
  for (int look = 1; node_.ok() && is_unbounded(); ++look) {
    const auto queues = node_.wait_until_delivered(kLook);
    if (!queues) {
      if (look != kPatience || !node_.ok()) continue;
      node_.report(graph::Health::kWarning,
                   "the simulation waits: subscribers have not taken for 2 s what they were sent");
      continue;
    }
    if (look > kPatience) node_.report(graph::Health::kOk, "");
    slices_ = 0;
    most_slices_ = kMostSlices;
    for (const graph::ReaderQueue& queue : *queues) {
      most_slices_ = std::max<std::size_t>(1, std::min(most_slices_, queue.depth));
    }
    return;
  }
}

}  // namespace prehend::nodes
