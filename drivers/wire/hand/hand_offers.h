#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "drivers/wire/hand/hand_axes.h"
#include "drivers/wire/hand/offered_hand.h"
#include "drivers/wire/time/time.h"
#include "msgs/actions.pb.h"
#include "msgs/joints.pb.h"
#include "nodes/emergency_stop_listener/emergency_stop_listener.h"
#include "prehend/graph/node.h"

namespace prehend::drivers {

/// What the simulated hand offers, by a real one: action /hand/move, topic /hand/command, service
/// /hand/stop; and, of a hand that can be switched off, /hand/off.
///
/// An emergency stop is the hand's stop: its axes halt and are held where they are, so that what
/// they grip stays gripped; power off would let it fall.
class HandOffers {
 public:
  HandOffers(graph::Node& node, OfferedHand& hand, const HandAxes& axes,
             nodes::EmergencyStopListener& emergency, bool has_off);

  /// Whether axes that are off are so because /hand/off was called. Any thread.
  bool is_switched_off() const { return is_switched_off_; }

 private:
  using Context = graph::ActionContext<msgs::MoveHandFeedback>;
  msgs::MoveHandResult move(const msgs::MoveHandGoal& goal, Context& context);
  /// @throws std::invalid_argument in the simulation's words.
  std::vector<OfferedHand::Target> check(const msgs::MoveHandGoal& goal) const;
  void command(const msgs::JointCommand& command);
  /// Why it is refused; "" when it was taken, or came late.
  std::string take(const msgs::JointCommand& command);
  msgs::Acknowledge stop(bool is_off);
  std::string wait_until_stopped();
  std::vector<std::size_t> named(
      const google::protobuf::RepeatedPtrField<std::string>& joints) const;

  graph::Node& node_;
  OfferedHand& hand_;
  const HandAxes& axes_;
  nodes::EmergencyStopListener& emergency_;
  std::atomic<bool> is_switched_off_ = false;
  std::atomic<std::int64_t> action_stamp_ = 0;  // ns, of the last goal
  std::string said_;                            // of the last command that was refused, once
  graph::Service stop_, off_;
  graph::Subscription command_;
  graph::ActionServer move_;
  nodes::EmergencyStopListener::Action emergency_stop_;
};

/// An OfferedHand over a Device whose with_driver() runs work on a driver of `kCount` axes. No
/// motion begins in an emergency stop, whose stop takes the same turn at the driver.
template <class Device, std::size_t kCount>
class OfferedDevice : public OfferedHand {
 public:
  OfferedDevice(Device& device, const nodes::EmergencyStopListener& emergency)
      : device_(device), emergency_(emergency) {}

  std::string move_to(const std::vector<Target>& targets, std::uint64_t& ticket) override {
    HandGoal<kCount> goal;
    for (const Target& target : targets) {
      goal.moves[target.axis] = true;
      goal.position[target.axis] = target.position;
      goal.speed[target.axis] = target.speed;
      goal.current[target.axis] = target.current;
    }
    return device_.with_driver([&](auto& driver, Time now) {
      const std::string stopped = emergency_.refusal();
      return stopped.empty() ? driver.move_to(goal, now, ticket) : stopped;
    });
  }
  MotionReport report(std::uint64_t ticket) override {
    return device_.with_driver([&](auto& driver, Time) { return driver.report(ticket); });
  }
  std::string command(CommandMode mode, const std::vector<std::size_t>& axes,
                      const std::vector<double>& values) override {
    std::array<bool, kCount> moves{};
    std::array<double, kCount> all{};
    for (std::size_t i = 0; i < axes.size(); ++i) {
      moves[axes[i]] = true;
      all[axes[i]] = values[i];
    }
    return device_.with_driver([&](auto& driver, Time now) {
      const std::string stopped = mode == CommandMode::kStop ? "" : emergency_.refusal();
      return stopped.empty() ? driver.command(mode, moves, all, now) : stopped;
    });
  }
  void stop(const std::string& why) override {
    device_.with_driver([&](auto& driver, Time now) { driver.stop(now, why); });
  }
  void power_off(const std::string& why) override {
    device_.with_driver([&](auto& driver, Time now) {
      if constexpr (requires { driver.power_off(now, why); }) {
        driver.power_off(now, why);
      } else {
        driver.stop(now, why);  // which is the same for it
      }
    });
  }
  std::vector<double> positions() override {
    const auto reading = device_.reading();
    return {reading.position.begin(), reading.position.end()};
  }
  bool is_settled() override {
    return device_.with_driver(
        [](auto& driver, Time) { return driver.is_settled() && driver.reading().is_answering(); });
  }
  bool is_connected() override { return device_.reading().is_connected(); }
  std::string state() override { return to_string(device_.reading().state); }

 private:
  Device& device_;
  const nodes::EmergencyStopListener& emergency_;
};

}  // namespace prehend::drivers
