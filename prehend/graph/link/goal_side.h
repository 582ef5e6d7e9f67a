#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

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

/// A goal at its client. As a callback source it hands out feedback.
class GoalCore : public CallbackSource, public std::enable_shared_from_this<GoalCore> {
 public:
  using OnFeedback = std::function<void(const std::string& body)>;
  GoalCore(std::shared_ptr<NodeLink> link, GoalSide& side, OfferType offer, std::string body,
           OnFeedback on_feedback);

  const OfferType& offer() const { return offer_; }
  std::uint64_t id() const { return id_; }
  bool done() const;
  void cancel();
  /// See GoalHandle::wait.
  Status wait(std::chrono::nanoseconds timeout, std::string& error, bool& has_result,
              std::string& result);

  // In the loop's thread:
  void push_feedback(std::string body);
  void finish(Status status, std::string error, bool has_result = false, std::string result = "");
  std::string server;  ///< instance it was sent to
  std::string body;    ///< until it was sent

 protected:
  bool run_one() override;

 private:
  const std::shared_ptr<NodeLink> link_;
  GoalSide& side_;  // used in the loop's thread only, which ends before it does
  const OfferType offer_;
  const std::uint64_t id_;
  const OnFeedback on_feedback_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> feedback_;
  std::uint64_t feedback_dropped_ = 0;
  bool done_ = false;
  Status status_ = Status::kTimeout;
  std::string error_;
  bool has_result_ = false;
  std::string result_;
};

/// The node's goals at others' actions. In the loop's thread only.
class GoalSide {
 public:
  GoalSide(PeerChannels& channels, const RegistryLink& registry)
      : channels_(channels), registry_(registry) {}

  void start(const std::shared_ptr<GoalCore>& goal);
  void cancel(std::uint64_t id);
  void look_again();
  void lose_server(const std::string& server);
  void take_feedback(msgs::graph::PeerMessage::Feedback& feedback);
  void take_result(msgs::graph::PeerMessage::GoalResult& result);
  void stop();

 private:
  bool advance(GoalCore& goal);

  PeerChannels& channels_;
  const RegistryLink& registry_;
  std::map<std::uint64_t, std::shared_ptr<GoalCore>> goals_;
  bool stopped_ = false;
};

/// What an ActionClient holds.
class ActionClientCore {
 public:
  ActionClientCore(std::shared_ptr<NodeLink> link, GoalSide& side, CallSide& calls, OfferType offer)
      : link_(link), side_(side), waiter_(link, calls, offer), offer_(std::move(offer)) {}

  const OfferType& offer() const { return offer_; }
  ServiceClientCore& waiter() { return waiter_; }
  std::shared_ptr<GoalCore> send(std::string body, GoalCore::OnFeedback on_feedback);

 private:
  const std::shared_ptr<NodeLink> link_;
  GoalSide& side_;
  ServiceClientCore waiter_;  // for wait_for_server
  const OfferType offer_;
};

}  // namespace prehend::graph
