#include "prehend/graph/link/subscription_core.h"

#include <algorithm>
#include <vector>

namespace prehend::graph {

SubscriptionCore::SubscriptionCore(std::shared_ptr<NodeLink> link, std::string topic, QoS qos,
                                   std::shared_ptr<const Schema> schema, Handler handler,
                                   std::uint64_t id, bool in_loop)
    : CallbackSource("subscription to " + topic),
      link_(std::move(link)),
      topic_(std::move(topic)),
      qos_(qos),
      schema_(std::move(schema)),
      handler_(std::move(handler)),
      id_(id),
      in_loop_(in_loop) {}

SubscriptionStatistics SubscriptionCore::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

void SubscriptionCore::count(const std::function<void(SubscriptionStatistics&)>& change) {
  const std::lock_guard lock(mutex_);
  change(statistics_);
}

void SubscriptionCore::set_withdraw(std::function<void()> withdraw) {
  const std::lock_guard lock(mutex_);
  withdraw_ = std::move(withdraw);
}

void SubscriptionCore::withdraw() {
  close();
  std::function<void()> withdraw;
  std::deque<WaitingMessage> dropped;
  {
    const std::lock_guard lock(mutex_);
    withdraw.swap(withdraw_);
    dropped.swap(queue_);
    queue_bytes_ = 0;
  }
  if (withdraw) link_->loop->post(std::move(withdraw));
}

void SubscriptionCore::push(WaitingMessage message) { ask_for_callbacks(put(std::move(message))); }

void SubscriptionCore::ask_for_callbacks(std::size_t count) {
  if (count > 0) link_->executor->schedule(shared_from_this(), count);
}

std::size_t SubscriptionCore::put(WaitingMessage message) {
  if (in_loop_) {
    link_->loop->post(
        [self = shared_from_this(), message = std::move(message)] { self->handler_(message); });
    return 0;
  }
  std::vector<WaitingMessage> dropped;  // freed outside the lock
  {
    const std::lock_guard lock(mutex_);
    const std::size_t bytes = message.content->bytes();
    ++statistics_.received;
    statistics_.bytes += bytes;
    while (!queue_.empty() &&
           (queue_.size() >= qos_.depth || queue_bytes_ + bytes > qos_.max_bytes)) {
      queue_bytes_ -= queue_.front().content->bytes();
      dropped.push_back(std::move(queue_.front()));
      queue_.pop_front();
      ++(qos_.policy == QoS::Policy::kLatest ? statistics_.superseded : statistics_.dropped);
    }
    queue_bytes_ += bytes;
    queue_.push_back(std::move(message));
    statistics_.queue_high_water = std::max(statistics_.queue_high_water, queue_.size());
    statistics_.queue_high_water_bytes = std::max(statistics_.queue_high_water_bytes, queue_bytes_);
  }
  // One that took a dropped one's place takes its turn, too.
  return dropped.empty() ? 1 : 0;
}

bool SubscriptionCore::run_one() {
  WaitingMessage message;
  {
    const std::lock_guard lock(mutex_);
    if (queue_.empty()) return false;
    message = std::move(queue_.front());
    queue_.pop_front();
    queue_bytes_ -= message.content->bytes();
  }
  const bool decoded = handler_(message);
  const std::lock_guard lock(mutex_);
  ++(decoded ? statistics_.delivered : statistics_.malformed);
  return true;
}

Subscription::Subscription(std::shared_ptr<SubscriptionCore> core) : core_(std::move(core)) {}

Subscription::~Subscription() {
  if (core_) core_->withdraw();
}

Subscription::Subscription(Subscription&&) noexcept = default;

Subscription& Subscription::operator=(Subscription&& other) noexcept {
  if (this != &other) {
    if (core_) core_->withdraw();
    core_ = std::move(other.core_);
  }
  return *this;
}

SubscriptionStatistics Subscription::statistics() const {
  return core_ ? core_->statistics() : SubscriptionStatistics();
}

const std::string& Subscription::topic() const {
  static const std::string kNone;
  return core_ ? core_->topic() : kNone;
}

}  // namespace prehend::graph
