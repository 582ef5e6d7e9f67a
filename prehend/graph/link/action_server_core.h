#pragma once

#include <atomic>
#include <chrono>
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
class ActionServerCore : public std::enable_shared_from_this<ActionServerCore> {
 public:
  using Handler = std::function<std::string(const std::string& body, GoalTask& task)>;
  ActionServerCore(std::shared_ptr<NodeLink> link, OfferType offer, Handler handler);
  ~ActionServerCore();

  const OfferType& offer() const { return offer_; }
  /// Begins to take goals.
  void start();
  /// A new goal; it preempts the one before.
  void accept(const std::string& client, msgs::graph::PeerMessage::Goal goal);
  void cancel(const std::string& client, std::uint64_t id);
  /// Cancels all goals, whoever sent them; false when there was none.
  bool cancel_all();
  /// Sends to the clients now and then, so that a dead one is noticed without the registry, too.
  void probe_client();
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
  bool cancel_where(const std::function<bool(const GoalTask&)>& applies);
  void fail(const GoalTask& task, const std::string& what);
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
  std::chrono::steady_clock::time_point last_probe_;  // in the loop's thread only
  std::mutex thread_mutex_;
  std::atomic<std::thread::id> thread_id_;
  std::thread thread_;
};

}  // namespace prehend::graph
