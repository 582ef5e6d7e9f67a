#include "drivers/ros/driver/ros_gripper.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "msgs/ros/to_ros.h"

namespace prehend::drivers::ros_link {

using recording::RosValue;
using Fields = RosValue::Fields;

RosGripper::RosGripper(RosPeer& peer, const Mapping::Gripper& options, robot::GripperModel model,
                       RosProblem tell)
    : options_(options),
      model_(std::move(model)),
      tell_(tell),
      joints_(peer, options.joint_states, std::move(tell)),
      action_(action_client(peer, options.action, "control_msgs/GripperCommand")) {}

RosGripper::State RosGripper::state() const {
  State state;
  const auto joint = joints_.joint(options_.joint, options_.loss_time);
  state.is_known = joint.has_value();
  if (joint) {
    state.opening = (joint->position - options_.closed_position) / options_.position_per_opening;
    state.velocity = joint->velocity / options_.position_per_opening;
    state.current = joint->effort / options_.effort_per_current;
  }
  const std::lock_guard lock(mutex_);
  state.moves = motion_.end == End::kRunning;
  state.blocked = motion_.end == End::kBlocked;
  return state;
}

std::string RosGripper::obstacle() const {
  if (!joints_.joint(options_.joint, options_.loss_time)) {
    return fmt::format("nothing comes of joint '{}' on {} of ROS", options_.joint,
                       options_.joint_states);
  }
  if (!action_->has_server()) return "no server of ROS has the action " + options_.action;
  return {};
}

std::string RosGripper::move_to(double opening, double current, std::uint64_t& ticket) {
  if (!(opening >= 0 && opening <= model_.max_opening)) {
    return fmt::format("an opening of {} m is none of 0 to {} m", opening, model_.max_opening);
  }
  if (!(current >= 0 && current <= model_.max_current)) {
    return fmt::format("a current of {} A is none of 0 to {} A", current, model_.max_current);
  }
  if (std::string why = obstacle(); !why.empty()) return why;
  const double effort =
      options_.effort_per_current * (current > 0 ? current : model_.nominal_current);
  const RosValue goal(Fields{
      {"command",
       RosValue(Fields{{"position", ros::ros_number(options_.closed_position +
                                                    opening * options_.position_per_opening)},
                       {"max_effort", ros::ros_number(effort)}})}});
  const std::lock_guard lock(mutex_);
  const std::uint64_t own = ticket = ++ticket_;
  motion_ = {};
  stops_ = false;
  action_->send(goal,
                [this, own](GoalEnd end_of_goal, const RosValue* result, const std::string& text) {
                  end(own, end_of_goal, result, text);
                });
  return {};
}

RosGripper::Motion RosGripper::motion(std::uint64_t ticket) const {
  const std::lock_guard lock(mutex_);
  if (ticket != ticket_) return {End::kReplaced, "another command took the gripper over"};
  return motion_;
}

void RosGripper::stop(const std::string& why) {
  const std::lock_guard lock(mutex_);
  if (motion_.end != End::kRunning || stops_) return;
  stops_ = true;
  motion_.reason = why;
  action_->cancel();
}

void RosGripper::end(std::uint64_t ticket, GoalEnd end, const RosValue* result,
                     const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (ticket != ticket_ || motion_.end != End::kRunning) return;
  if (result && (*result)["reached_goal"].integer() != 0) {
    motion_ = {End::kReached, {}};
  } else if (result && (*result)["stalled"].integer() != 0) {
    motion_ = {End::kBlocked, "blocked"};
  } else {
    const std::string why = !motion_.reason.empty() ? motion_.reason
                            : text.empty()
                                ? fmt::format("the gripper's action of ROS {}", to_string(end))
                                : text;
    motion_ = {End::kFailed, why};
  }
}

void RosGripper::look() {
  const std::string why = obstacle();
  if (why.empty()) return;
  const std::lock_guard lock(mutex_);
  if (motion_.end != End::kRunning) return;
  action_->cancel();
  motion_ = {End::kFailed, why};
  tell_("a motion of the gripper was given up: " + why);
}

}  // namespace prehend::drivers::ros_link
