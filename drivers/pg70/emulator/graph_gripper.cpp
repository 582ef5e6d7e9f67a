#include "drivers/pg70/emulator/graph_gripper.h"

#include <algorithm>
#include <cmath>

namespace prehend::drivers::pg70 {
namespace {

constexpr double kPeriod = 0.01;      // s between commands
constexpr double kNear = 1e-3;        // m, from where on the simulation itself finds the target
constexpr double kLeastSpeed = 2e-3;  // m/s, on the way there

}  // namespace

GraphGripper::GraphGripper(graph::Node& node)
    : node_(node),
      publisher_(
          node.advertise<msgs::GripperCommand>("/world/gripper/command", graph::QoS::queue(10))),
      subscription_(node.subscribe<msgs::GripperState>(
          "/world/gripper/state", graph::QoS::queue(10),
          [this](const graph::Received<msgs::GripperState>& state) {
            const std::lock_guard lock(mutex_);
            const std::int64_t stamp = state->header().stamp();
            // The first one, and those of a simulation begun anew, begin where time stands.
            const std::int64_t passed = last_stamp_ > 0 ? stamp - last_stamp_ : 0;
            last_stamp_ = stamp;
            motion_ = {
                state->opening(), state->velocity(), state->current(),
                motion_.time + 1e-9 * static_cast<double>(std::max<std::int64_t>(0, passed))};
          })) {}

void GraphGripper::command(const Command& command) {
  const std::lock_guard lock(mutex_);
  command_ = command;
  since_sent_ = kPeriod;
}

void GraphGripper::set_stuck(bool stuck) {
  const std::lock_guard lock(mutex_);
  stuck_ = stuck;
}

// The simulated gripper's position command knows no speed, so its way there is a speed command that
// can still brake at the target.
msgs::GripperCommand GraphGripper::message() const {
  msgs::GripperCommand message;
  message.set_current_limit(command_.current);
  const Drive drive = stuck_ ? Drive::kHold : command_.drive;
  const double way = command_.value - motion_.opening;
  switch (drive) {
    case Drive::kPosition:
      if (std::abs(way) < kNear) {
        message.set_mode(msgs::GripperCommand::POSITION);
        message.set_value(command_.value);
        break;
      }
      message.set_mode(msgs::GripperCommand::VELOCITY);
      message.set_value(
          std::copysign(std::clamp(std::sqrt(command_.acceleration * std::abs(way)), kLeastSpeed,
                                   std::max(command_.speed, kLeastSpeed)),
                        way));
      break;
    case Drive::kVelocity:
      message.set_mode(msgs::GripperCommand::VELOCITY);
      message.set_value(command_.value);
      break;
    case Drive::kCurrent:
      message.set_mode(msgs::GripperCommand::CURRENT);
      message.set_value(command_.value);
      message.set_current_limit(0);
      break;
    default:
      message.set_mode(msgs::GripperCommand::STOP);
  }
  return message;
}

GripperPlant::Motion GraphGripper::advance(double seconds) {
  msgs::GripperCommand command;
  Motion motion;
  bool is_due = false;
  {
    const std::lock_guard lock(mutex_);
    motion = motion_;
    since_sent_ += seconds;
    is_due = since_sent_ >= kPeriod;
    if (is_due) {
      since_sent_ = 0;
      command = message();
    }
  }
  if (is_due) {
    command.mutable_header()->set_stamp(node_.clock().now());
    publisher_.publish(command);
  }
  return motion;
}

}  // namespace prehend::drivers::pg70
