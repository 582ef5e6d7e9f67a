#include "prehend/graph/link/publisher_core.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <stdexcept>

#include "prehend/graph/link/subscription_core.h"

namespace prehend::graph {
namespace {

// The outbox is emptied within microseconds unless the machine is overloaded, so a burst may be
// longer than the depth meant for slow readers.
constexpr std::size_t kLeastOutbox = 10000;

// Who publishes again sooner than this after the last time is in a burst: its messages are left to
// the loop's thread, which sends those that have come together in one go.
constexpr auto kBurst = std::chrono::microseconds(20);

// Of messages published together so many share memory, which is given back with the last of them.
constexpr std::size_t kSharingMemory = 512;

}  // namespace

PublisherCore::PublisherCore(std::shared_ptr<NodeLink> link, std::string topic, QoS qos,
                             std::shared_ptr<const Schema> schema, std::uint64_t id)
    : link_(std::move(link)),
      head_{std::move(topic), link_->node_name, schema->hash},
      qos_(qos),
      schema_(std::move(schema)),
      id_(id),
      topic_name_(head_.topic),
      sender_name_(head_.sender) {}

bool PublisherCore::has_local() const {
  const std::lock_guard lock(mutex_);
  return !local_.empty();
}

std::shared_ptr<SlabPool> PublisherCore::pool() const {
  const std::lock_guard lock(mutex_);
  return slab_readers_ ? link_->slabs : nullptr;
}

std::shared_ptr<Slab> PublisherCore::slab_for(std::size_t bytes) const {
  return large_part(pool(), bytes);
}

std::shared_ptr<const Content> PublisherCore::content_of(const Message& message) const {
  if (!has_local()) return std::make_shared<Content>(encode(message, pool()));
  return content_of_copy(message);
}

std::shared_ptr<const Content> PublisherCore::content_of_copy(const Message& message) const {
  std::shared_ptr<Message> copy(message.New());
  copy->CopyFrom(message);
  return std::make_shared<Content>(std::move(copy), SharedBytes(), nullptr, pool());
}

void PublisherCore::publish_copy(const Message& message) {
  publish_content(content_of(message), header_stamp(message));
}

void PublisherCore::publish_moved(Message& message) {
  const std::int64_t stamp = header_stamp(message);
  if (has_local() && message.GetArena() == nullptr) {
    std::shared_ptr<Message> object(message.New());
    message.GetReflection()->Swap(&message, object.get());
    return publish_content(
        std::make_shared<Content>(std::move(object), SharedBytes(), nullptr, pool()), stamp);
  }
  const auto slabs = pool();
  SharedBytes payload = slabs ? SharedBytes() : take_payload(message);
  publish(payload.empty() ? encode(message, slabs)
                          : encode_with_payload(message, std::move(payload), nullptr),
          stamp);
}

void PublisherCore::publish_apart(Message& message, SharedBytes payload,
                                  std::shared_ptr<Slab> slab) {
  check_payload_comes_apart(message);
  const std::int64_t stamp = header_stamp(message);
  if (!has_local()) {
    return publish(encode_with_payload(message, std::move(payload), std::move(slab), pool()),
                   stamp);
  }
  std::shared_ptr<Message> object(message.New());
  message.GetReflection()->Swap(&message, object.get());
  publish_content(
      std::make_shared<Content>(std::move(object), std::move(payload), std::move(slab), pool()),
      stamp);
}

void PublisherCore::publish_shared(std::shared_ptr<const Message> message) {
  if (!message) throw std::invalid_argument("topic " + head_.topic + ": no message given");
  if (!has_local()) return publish_copy(*message);
  const std::int64_t stamp = header_stamp(*message);
  publish_content(std::make_shared<Content>(std::move(message), SharedBytes(), nullptr, pool()),
                  stamp);
}

void PublisherCore::publish_each(std::span<const Message* const> messages) {
  std::vector<std::shared_ptr<const Content>> contents;
  contents.reserve(messages.size());
  const bool as_objects = has_local();
  const auto slabs = pool();
  BatchMemory<std::uint8_t> batch(kBatchRoom);
  for (const Message* message : messages) {
    if (contents.size() % kSharingMemory == 0) batch = BatchMemory<std::uint8_t>(kBatchRoom);
    contents.push_back(as_objects ? content_of_copy(*message)
                                  : std::allocate_shared<Content>(BatchMemory<Content>(batch),
                                                                  encode(*message, slabs, &batch)));
  }
  const std::int64_t now = link_->clock->now();
  bool was_empty = false;
  {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < messages.size(); ++i) {
      was_empty = put(std::move(contents[i]), header_stamp(*messages[i]), now) || was_empty;
    }
  }
  start_drain(was_empty);
}

void PublisherCore::publish(EncodedMessage message, std::int64_t stamp) {
  publish_content(std::make_shared<Content>(std::move(message)), stamp);
}

void PublisherCore::publish_content(std::shared_ptr<const Content> content, std::int64_t stamp) {
  const std::int64_t now = link_->clock->now();
  bool was_empty = false;
  {
    const std::lock_guard lock(mutex_);
    was_empty = put(std::move(content), stamp, now);
  }
  start_drain(was_empty);
}

bool PublisherCore::put(std::shared_ptr<const Content> content, std::int64_t stamp,
                        std::int64_t now) {
  if (stopped_) return false;
  const std::size_t bytes = content->bytes();
  ++statistics_.published;
  statistics_.bytes += bytes;
  OutgoingMessage message{std::move(content), ++last_sequence_, stamp != 0 ? stamp : now, now};
  for (const auto& subscription : local_) hand_over(*subscription, message);
  if (!keeps_) return false;
  make_room(bytes);
  outbox_bytes_ += bytes;
  outbox_.push_back(std::move(message));
  return outbox_.size() == 1;
}

void PublisherCore::start_drain(bool was_empty) {
  if (!was_empty) return;
  std::function<void()> drain;
  bool in_burst = false;
  {
    const std::lock_guard lock(mutex_);
    drain = drain_;
    const auto now = std::chrono::steady_clock::now();
    in_burst = now - last_drain_ < kBurst;
    last_drain_ = now;
  }
  if (!drain || (!in_burst && link_->loop->try_turn(drain))) return;
  link_->loop->post(std::move(drain));
}

void PublisherCore::hand_over(SubscriptionCore& subscription,
                              const OutgoingMessage& message) const {
  auto info = std::make_shared<const MessageInfo>(MessageInfo{topic_name_, message.sequence,
                                                              message.stamp, message.publish_time,
                                                              sender_name_, head_.schema_hash});
  subscription.push({message.content, std::move(info), schema_});
}

void PublisherCore::make_room(std::size_t bytes) {
  while (!outbox_.empty() && (outbox_.size() >= std::max(qos_.depth, kLeastOutbox) ||
                              outbox_bytes_ + bytes > qos_.max_bytes)) {
    outbox_bytes_ -= outbox_.front().content->bytes();
    outbox_.pop_front();
    const std::uint64_t readers = std::max<std::uint64_t>(1, statistics_.subscribers);
    (qos_.policy == QoS::Policy::kLatest ? statistics_.superseded : statistics_.dropped) += readers;
  }
}

bool PublisherCore::wait_for_subscribers(std::size_t count,
                                         std::chrono::nanoseconds timeout) const {
  if (timeout.count() > 0) {
    const std::string refused =
        refuse_blocking(*link_->clock, "topic " + topic() + ": wait_for_subscribers",
                        "publish latched, or wait in a thread of your own");
    if (!refused.empty()) throw std::logic_error(refused);
  }
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline_after(timeout),
                      [&] { return stopped_ || statistics_.subscribers >= count; });
  return statistics_.subscribers >= count && !stopped_;
}

PublisherStatistics PublisherCore::statistics() const {
  const std::lock_guard lock(mutex_);
  PublisherStatistics result = statistics_;
  result.slab_bytes = link_->slabs ? link_->slabs->bytes() : 0;
  return result;
}

void PublisherCore::count_dropped(std::uint64_t messages) {
  const std::lock_guard lock(mutex_);
  (qos_.policy == QoS::Policy::kLatest ? statistics_.superseded : statistics_.dropped) += messages;
}

void PublisherCore::count_waiting(std::uint64_t messages, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  statistics_.queue_high_water = std::max(statistics_.queue_high_water, messages);
  statistics_.queue_high_water_bytes = std::max(statistics_.queue_high_water_bytes, bytes);
}

void PublisherCore::set_drain(std::function<void()> drain) {
  const std::lock_guard lock(mutex_);
  drain_ = std::move(drain);
}

PublisherCore::Taken PublisherCore::take_outbox() {
  Taken taken;
  const std::lock_guard lock(mutex_);
  taken.messages.swap(outbox_);
  taken.last_sequence = last_sequence_;
  outbox_bytes_ = 0;
  return taken;
}

void PublisherCore::set_outbox_use(bool keeps, bool slab_readers) {
  const std::lock_guard lock(mutex_);
  keeps_ = keeps;
  slab_readers_ = slab_readers;
}

void PublisherCore::set_subscribers(std::size_t count) {
  const std::lock_guard lock(mutex_);
  statistics_.subscribers = count;
  changed_.notify_all();
}

void PublisherCore::add_local(const std::shared_ptr<SubscriptionCore>& subscription,
                              const std::deque<OutgoingMessage>* history, std::size_t depth) {
  const std::lock_guard lock(mutex_);
  const bool is_known = std::any_of(local_.begin(), local_.end(),
                                    [&](const auto& other) { return other == subscription; });
  if (is_known) return;
  std::vector<const OutgoingMessage*> past;
  if (history) {
    for (const OutgoingMessage& message : *history) past.push_back(&message);
    for (const OutgoingMessage& message : outbox_) past.push_back(&message);
  }
  const std::size_t wanted = std::min(depth, past.size());
  for (std::size_t i = past.size() - wanted; i < past.size(); ++i) {
    hand_over(*subscription, *past[i]);
  }
  if (!stopped_) local_.push_back(subscription);
}

void PublisherCore::remove_local(std::uint64_t subscription) {
  const std::lock_guard lock(mutex_);
  std::erase_if(local_, [&](const auto& other) { return other->id() == subscription; });
}

void PublisherCore::stop() {
  std::vector<std::shared_ptr<SubscriptionCore>> dropped;  // destroyed outside the lock
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  dropped.swap(local_);
  changed_.notify_all();
}

}  // namespace prehend::graph
