#include "nodes/replay/delivery_window.h"

#include <algorithm>
#include <chrono>

namespace prehend {
namespace {

constexpr std::size_t kMostBytes = std::size_t{64} << 20;  // on the way, however long the queues
// So few that all are taken by the connection at once: what waits for it in the publisher is kept
// by the topic's own depth, and that may be 1.
constexpr std::size_t kMostMessages = 24;
constexpr auto kPatience = std::chrono::seconds(2);

}  // namespace

bool DeliveryWindow::admit(const graph::RawPublisher& publisher, std::size_t bytes) {
  if (!has_room(publisher, bytes) && !wait_until_delivered()) return false;
  Topic& topic = topics_[publisher.topic()];
  topic.readers = publisher.subscriber_count();
  ++topic.sent;
  ++messages_;
  bytes_ += bytes;
  return true;
}

bool DeliveryWindow::has_room(const graph::RawPublisher& publisher, std::size_t bytes) {
  const Topic& topic = topics_[publisher.topic()];
  if (topic.readers != publisher.subscriber_count()) return false;  // whose queue is not known yet
  const bool fits_queue = topic.depth == 0 || topic.sent < topic.depth;
  return fits_queue && messages_ < kMostMessages && (bytes_ == 0 || bytes_ + bytes <= most_bytes_);
}

bool DeliveryWindow::wait_until_delivered() {
  bool reported = false;
  while (node_.ok()) {
    const auto queues = node_.wait_until_delivered(kPatience);
    if (!queues) {
      if (!node_.ok()) break;
      reported = true;
      node_.report(graph::Health::kWarning,
                   "the replay waits: subscribers have not taken for 2 s what they were sent");
      continue;
    }
    if (reported) node_.report(graph::Health::kOk, "");
    take(*queues);
    return true;
  }
  return false;
}

void DeliveryWindow::take(const graph::ReaderQueues& queues) {
  bytes_ = messages_ = 0;
  most_bytes_ = kMostBytes;
  for (auto& [name, topic] : topics_) topic.depth = topic.sent = 0;
  for (const graph::ReaderQueue& queue : queues) {
    Topic& topic = topics_[queue.topic];
    topic.depth = topic.depth == 0 ? queue.depth : std::min(topic.depth, queue.depth);
    most_bytes_ = std::min(most_bytes_, queue.max_bytes);
  }
}

}  // namespace prehend
