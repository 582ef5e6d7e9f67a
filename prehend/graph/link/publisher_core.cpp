#include "prehend/graph/link/publisher_core.h"

#include <algorithm>
#include <stdexcept>

namespace prehend::graph {
namespace {

// The outbox is emptied within microseconds unless the machine is overloaded, so a burst may be
// longer than the depth meant for slow readers.
constexpr std::size_t kLeastOutbox = 10000;

const std::shared_ptr<PublisherCore>& checked(const std::shared_ptr<PublisherCore>& core) {
  if (!core) throw std::logic_error("this publisher was not made by Node::advertise");
  return core;
}

}  // namespace

PublisherCore::PublisherCore(std::shared_ptr<NodeLink> link, std::string topic, QoS qos,
                             std::shared_ptr<const Schema> schema, std::uint64_t id)
    : link_(std::move(link)),
      topic_(std::move(topic)),
      qos_(qos),
      schema_(std::move(schema)),
      id_(id) {}

void PublisherCore::publish(MessageFrames message, std::int64_t stamp) {
  msgs::graph::Envelope envelope;
  envelope.set_publish_time(link_->clock->now());
  envelope.set_stamp(stamp != 0 ? stamp : envelope.publish_time());
  envelope.set_sender(link_->node_name);
  envelope.set_schema_hash(schema_->hash);
  std::function<void()> drain;
  {
    const std::lock_guard lock(mutex_);
    if (stopped_) return;
    ++statistics_.published;
    envelope.set_sequence(next_sequence_++);
    make_room(message.bytes());
    outbox_bytes_ += message.bytes();
    outbox_.push_back({envelope.SerializeAsString(), std::move(message), envelope.sequence()});
    if (outbox_.size() == 1) drain = drain_;
  }
  if (drain) link_->loop->post(std::move(drain));
}

void PublisherCore::make_room(std::size_t bytes) {
  while (!outbox_.empty() && (outbox_.size() >= std::max(qos_.depth, kLeastOutbox) ||
                              outbox_bytes_ + bytes > qos_.max_bytes)) {
    outbox_bytes_ -= outbox_.front().message.bytes();
    outbox_.pop_front();
    const std::uint64_t readers = std::max<std::uint64_t>(1, statistics_.subscribers);
    (qos_.policy == QoS::Policy::kLatest ? statistics_.superseded : statistics_.dropped) += readers;
  }
}

bool PublisherCore::wait_for_subscribers(std::size_t count,
                                         std::chrono::nanoseconds timeout) const {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline_after(timeout),
                      [&] { return stopped_ || statistics_.subscribers >= count; });
  return statistics_.subscribers >= count && !stopped_;
}

PublisherStatistics PublisherCore::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

void PublisherCore::count_dropped(std::uint64_t messages) {
  const std::lock_guard lock(mutex_);
  (qos_.policy == QoS::Policy::kLatest ? statistics_.superseded : statistics_.dropped) += messages;
}

void PublisherCore::set_drain(std::function<void()> drain) {
  const std::lock_guard lock(mutex_);
  drain_ = std::move(drain);
}

std::deque<TopicFrames> PublisherCore::take_outbox() {
  std::deque<TopicFrames> taken;
  const std::lock_guard lock(mutex_);
  taken.swap(outbox_);
  outbox_bytes_ = 0;
  return taken;
}

void PublisherCore::set_subscribers(std::size_t count) {
  const std::lock_guard lock(mutex_);
  statistics_.subscribers = count;
  changed_.notify_all();
}

void PublisherCore::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

bool PublisherBase::wait_for_subscribers(std::size_t count,
                                         std::chrono::nanoseconds timeout) const {
  return checked(core_)->wait_for_subscribers(count, timeout);
}

std::size_t PublisherBase::subscriber_count() const {
  return checked(core_)->statistics().subscribers;
}

PublisherStatistics PublisherBase::statistics() const { return checked(core_)->statistics(); }

const std::string& PublisherBase::topic() const { return checked(core_)->topic(); }

void PublisherBase::publish_copy(const google::protobuf::Message& message) const {
  checked(core_)->publish(encode(message), header_stamp(message));
}

void PublisherBase::publish_moved(google::protobuf::Message& message) const {
  const std::int64_t stamp = header_stamp(message);
  checked(core_)->publish(encode_moving(message), stamp);
}

void PublisherBase::publish_payload(google::protobuf::Message& message,
                                    std::vector<std::uint8_t>&& payload) const {
  checked(core_)->publish(encode_with_payload(message, std::move(payload)), header_stamp(message));
}

void PublisherBase::publish_encoded(std::string bytes, std::int64_t stamp) const {
  checked(core_)->publish(encode_raw(std::move(bytes)), stamp);
}

}  // namespace prehend::graph
