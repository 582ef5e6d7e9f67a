#pragma once

#include <array>
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "drivers/sdh/driver/device.h"
#include "drivers/sdh/node/hand_axes.h"
#include "msgs/actions.pb.h"
#include "msgs/joints.pb.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::sdh {

/// What the simulated hand offers, by the real one: action /hand/move, topic /hand/command, service
/// /hand/stop; and /hand/off besides, which switches the axes off.
class HandOffers {
 public:
  HandOffers(graph::Node& node, Device& device, const HandAxes& axes);

 private:
  using Context = graph::ActionContext<msgs::MoveHandFeedback>;
  struct Named {
    HandGoal goal;
    std::vector<std::size_t> axes;  // in the order of their names
  };
  msgs::MoveHandResult move(const msgs::MoveHandGoal& goal, Context& context);
  /// @throws std::invalid_argument in the simulation's words.
  Named check(const msgs::MoveHandGoal& goal) const;
  void command(const msgs::JointCommand& command);
  /// Why it is refused; "" when it was taken, or came late.
  std::string take(const msgs::JointCommand& command);
  msgs::Acknowledge stop(bool is_off);
  std::string wait_until_stopped();
  std::vector<std::size_t> named(
      const google::protobuf::RepeatedPtrField<std::string>& joints) const;

  graph::Node& node_;
  Device& device_;
  const HandAxes& axes_;
  std::atomic<std::int64_t> action_stamp_ = 0;  // ns, of the last goal
  std::string said_;                            // of the last command that was refused, once
  graph::Service stop_, off_;
  graph::Subscription command_;
  graph::ActionServer move_;
};

}  // namespace prehend::drivers::sdh
