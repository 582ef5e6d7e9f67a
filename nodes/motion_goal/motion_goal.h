#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "prehend/graph/node.h"

namespace prehend::nodes {

/// The last goal that a cycle sent to the server of a motion, and how long ago that server gave a
/// word of it. Servers send feedback while they move something (those of this repository at 20 Hz),
/// so that silence means that nobody carries the motion out. For the node's callbacks only.
template <class Goal, class Feedback, class Result>
class MotionGoal {
 public:
  MotionGoal(graph::Node& node, const std::string& action)
      : node_(node), client_(node.action_client<Goal, Feedback, Result>(action)) {}

  void send(const Goal& goal) {
    // Feedback of an older goal, which may still come, counts nothing.
    heard_ = std::make_shared<std::int64_t>(node_.clock().now());
    handle_ = client_.send(
        goal, [heard = heard_, clock = node_.clock()](const Feedback&) { *heard = clock.now(); });
  }

  /// Its end; nothing while it goes on, or when there is none.
  std::optional<graph::Outcome<Result>> end() const {
    if (!handle_ || !handle_.done()) return std::nullopt;
    return handle_.wait(std::chrono::nanoseconds(0));
  }

  /// Seconds by the node's clock since the goal was sent or the last feedback came; 0 when it has
  /// ended, or there is none; infinity when its server died.
  double answer_age() const {
    if (!handle_) return 0;
    const auto outcome = end();
    if (!outcome) return graph::seconds(node_.clock().now() - *heard_);
    return outcome->status() == graph::Status::kServerGone ? std::numeric_limits<double>::infinity()
                                                           : 0;
  }

  /// Cancels it when it goes on, and forgets it.
  void stop() {
    if (handle_ && !handle_.done()) handle_.cancel();
    handle_ = {};
  }

 private:
  graph::Node& node_;
  graph::ActionClient<Goal, Feedback, Result> client_;
  graph::GoalHandle<Result> handle_;
  std::shared_ptr<std::int64_t> heard_;  // ns, of the node's clock
};

}  // namespace prehend::nodes
