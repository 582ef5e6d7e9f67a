#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "prehend/graph/link/content.h"
#include "prehend/graph/link/executor.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/subscription.h"

namespace prehend::graph {

/// A message that waits for its callback.
struct WaitingMessage {
  std::shared_ptr<const Content> content;
  std::shared_ptr<const MessageInfo> info;
  std::shared_ptr<const Schema> schema;  ///< of raw subscriptions
};

/// The queue between the loop's thread, which puts messages in under QoS, and the callback.
class SubscriptionCore : public CallbackSource,
                         public std::enable_shared_from_this<SubscriptionCore> {
 public:
  /// False: the message could not be decoded.
  using Handler = std::function<bool(const WaitingMessage&)>;

  /// `schema` null: any type. `in_loop`: the handler is called in the loop's thread at once.
  SubscriptionCore(std::shared_ptr<NodeLink> link, std::string topic, QoS qos,
                   std::shared_ptr<const Schema> schema, Handler handler, std::uint64_t id,
                   bool in_loop);

  const std::string& topic() const { return topic_; }
  const QoS& qos() const { return qos_; }
  const std::shared_ptr<const Schema>& schema() const { return schema_; }
  std::uint64_t id() const { return id_; }
  std::uint64_t schema_hash() const { return schema_ ? schema_->hash : 0; }

  SubscriptionStatistics statistics() const;
  /// Changes the counters.
  void count(const std::function<void(SubscriptionStatistics&)>& change);
  void set_withdraw(std::function<void()> withdraw);
  /// Ends the subscription: no callback any more, then tells the loop.
  void withdraw();

  /// From the loop's thread, or a publisher's of this process.
  void push(WaitingMessage message);
  /// The same, but asks for no callback yet: returns how many callbacks are to be asked for.
  std::size_t put(WaitingMessage message);
  void ask_for_callbacks(std::size_t count);

 protected:
  bool run_one() override;

 private:
  const std::shared_ptr<NodeLink> link_;
  const std::string topic_;
  const QoS qos_;
  const std::shared_ptr<const Schema> schema_;
  const Handler handler_;
  const std::uint64_t id_;
  const bool in_loop_;

  mutable std::mutex mutex_;
  std::function<void()> withdraw_;
  std::deque<WaitingMessage> queue_;
  std::size_t queue_bytes_ = 0;
  SubscriptionStatistics statistics_;
};

}  // namespace prehend::graph
