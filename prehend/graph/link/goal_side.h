#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "msgs/graph.pb.h"
#include "prehend/graph/action.h"
#include "prehend/graph/link/call_side.h"
#include "prehend/graph/link/executor.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/link/offers.h"
#include "prehend/graph/link/peer_channels.h"
#include "prehend/graph/link/registry_link.h"

namespace prehend::graph {

class GoalSide;

/// How a goal ended.
struct GoalEnd {
  Status status = Status::kTimeout;
  std::string error;
  std::optional<std::string> result;
};

/// A goal at its client. As a callback source it hands out feedback.
class GoalCore : public CallbackSource, public std::enable_shared_from_this<GoalCore> {
 public:
  using OnFeedback = std::function<void(const std::string& body)>;
  using OnEnd = std::function<void(const GoalEnd&)>;
  GoalCore(std::shared_ptr<NodeLink> link, GoalSide& side, OfferType offer, std::string body,
           OnFeedback on_feedback, const GoalOptions& options);

  const OfferType& offer() const { return offer_; }
  std::uint64_t id() const { return id_; }
  bool done() const;
  void cancel();
  /// See GoalHandle::wait.
  GoalEnd wait(std::chrono::nanoseconds timeout);
  /// Calls back among the node's callbacks when the goal has ended, after all of its feedback.
  void on_end(OnEnd callback);

  // In the loop's thread:
  void push_feedback(std::string body);
  /// No feedback from now on; does not wait for a callback that runs.
  void stop_feedback();
  void finish(Status status, std::string error, std::optional<std::string> result = std::nullopt);
  std::string server;                           ///< instance it was sent to
  std::string body;                             ///< until it was sent
  std::chrono::steady_clock::time_point since;  ///< waits for that server, or for any
  std::optional<IoLoop::Alarm> alarm;           ///< of its timeout
  const GoalOptions options;
  const std::chrono::steady_clock::time_point deadline;

 protected:
  bool run_one() override;

 private:
  void schedule_end(OnEnd callback);
  void deliver_feedback();

  const std::shared_ptr<NodeLink> link_;
  GoalSide& side_;  // used in the loop's thread only, which ends before it does
  const OfferType offer_;
  const std::uint64_t id_;
  const OnFeedback on_feedback_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> feedback_;
  std::uint64_t feedback_dropped_ = 0;
  bool feedback_stopped_ = false;
  bool done_ = false;
  GoalEnd end_;
  std::vector<OnEnd> on_end_;
};

/// The node's goals at others' actions. In the loop's thread only.
class GoalSide {
 public:
  GoalSide(IoLoop& loop, PeerChannels& channels, const RegistryLink& registry)
      : loop_(loop), channels_(channels), registry_(registry) {}

  void start(const std::shared_ptr<GoalCore>& goal);
  void cancel(std::uint64_t id);
  void look_again();
  void lose_server(const std::string& server);
  /// Ends goals of servers that died before a connection to them stood.
  void check_connections();
  void take_feedback(const std::string& server, msgs::graph::PeerMessage::Feedback& feedback);
  void take_result(const std::string& server, msgs::graph::PeerMessage::GoalResult& result);
  void stop();

 private:
  using Goals = std::map<std::uint64_t, std::shared_ptr<GoalCore>>;
  bool advance(GoalCore& goal);
  void expire(std::uint64_t id);
  void send_cancel(const GoalCore& goal);
  Goals::iterator erase(Goals::iterator goal);

  IoLoop& loop_;
  PeerChannels& channels_;
  const RegistryLink& registry_;
  Goals goals_;
  bool stopped_ = false;
};

/// What an ActionClient holds.
class ActionClientCore {
 public:
  ActionClientCore(std::shared_ptr<NodeLink> link, GoalSide& side, CallSide& calls, OfferType offer)
      : link_(link), side_(side), waiter_(link, calls, offer), offer_(std::move(offer)) {}

  const OfferType& offer() const { return offer_; }
  ServiceClientCore& waiter() { return waiter_; }
  std::shared_ptr<GoalCore> send(std::string body, GoalCore::OnFeedback on_feedback,
                                 const GoalOptions& options);

 private:
  const std::shared_ptr<NodeLink> link_;
  GoalSide& side_;
  ServiceClientCore waiter_;  // for wait_for_server
  const OfferType offer_;
};

}  // namespace prehend::graph
