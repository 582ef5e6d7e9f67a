#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "msgs/graph.pb.h"
#include "prehend/graph/action.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/link/offers.h"

namespace prehend::graph {

/// A goal at its server.
class GoalTask {
 public:
  std::shared_ptr<NodeLink> link;
  std::string client;
  std::uint64_t id = 0;
  std::string body;
  std::atomic<bool> cancelled = false;
  std::atomic<bool> preempted = false;
};

/// An action's server: one thread that works on one goal at a time. Thread-safe.
class ActionServerCore {
 public:
  using Handler = std::function<std::string(const std::string& body, GoalTask& task)>;
  ActionServerCore(std::shared_ptr<NodeLink> link, OfferType offer, Handler handler);
  ~ActionServerCore();

  const OfferType& offer() const { return offer_; }
  /// A new goal; it preempts the one before.
  void accept(const std::string& client, msgs::graph::PeerMessage::Goal goal);
  void cancel(const std::string& client, std::uint64_t id);
  /// Cancels the goals of a client that is gone.
  void lose_client(const std::string& client);
  void set_withdraw(std::function<void()> withdraw) { withdraw_ = std::move(withdraw); }
  /// Cancels; no goal is taken any more.
  void begin_stop();
  /// The same and waits for the handler.
  void stop();
  void withdraw();

 private:
  void work();
  void run(GoalTask& task);
  void cancel_where(const std::function<bool(const GoalTask&)>& applies);
  void send_end(const GoalTask& task, msgs::graph::PeerMessage::GoalStatus status,
                const std::string& error, const std::string* body = nullptr);

  const std::shared_ptr<NodeLink> link_;
  const OfferType offer_;
  const Handler handler_;
  std::function<void()> withdraw_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<GoalTask> current_;
  std::shared_ptr<GoalTask> pending_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace prehend::graph
