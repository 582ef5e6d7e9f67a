#include "drivers/sdh/node/hand_axes.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/text/nearest_match.h"

namespace prehend::drivers::sdh {

HandAxes::HandAxes(const robot::Platform& platform, const std::vector<std::string>& joints,
                   double most_current)
    : hand_(platform.hand), joints_(joints), most_current_(most_current) {
  const bool has_joints = platform.hand_port == robot::HandPort::kJoints;
  if (!has_joints || hand_.actuated.size() != kAxes) {
    throw geometry::InputError(
        has_joints ? fmt::format("the hand of platform {} has {} motors, an SDH-2 has {}",
                                 platform.name, hand_.actuated.size(), kAxes)
                   : fmt::format("platform {} has a gripper, moved through /gripper, and no SDH-2",
                                 platform.name),
        "Name a platform with an SDH-2, platform:=kr5_sdh");
  }
  if (joints.size() != kAxes) {
    throw geometry::InputError(
        fmt::format("{} names for the {} axes of an SDH-2", joints.size(), kAxes),
        "Give axes:= the hand's joints in the order of the axes");
  }
  limits_ = sdh2_limits();
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (std::ranges::count(joints, joints[i]) > 1) {
      throw geometry::InputError("axis '" + joints[i] + "' is named twice",
                                 "Give each of the hand's joints one place in axes");
    }
    actuated_[i] = hand_.actuated_index(joints[i]);
    const robot::Joint& joint = hand_.model.joints[static_cast<std::size_t>(
        hand_.actuated[static_cast<std::size_t>(actuated_[i])])];
    limits_.lower[i] = std::max(limits_.lower[i], joint.lower);
    limits_.upper[i] = std::min(limits_.upper[i], joint.upper);
    limits_.max_speed[i] = std::min(limits_.max_speed[i], joint.max_velocity);
    limits_.max_current[i] = most_current;
    most_effort_[i] = joint.max_effort;
    const bool can_be = limits_.lower[i] < limits_.upper[i] && std::isfinite(joint.max_effort) &&
                        joint.max_effort > 0 && limits_.max_speed[i] > 0;
    if (!can_be) {
      throw geometry::InputError(
          fmt::format("joint '{}' of platform {} has no limits that axis {} of an SDH-2 could keep",
                      joints[i], platform.name, i),
          "Its URDF needs limits of position, velocity and effort within those of the axis");
    }
  }
  for (std::size_t j = 0; j < hand_.model.joints.size(); ++j) {
    if (hand_.model.joints[j].kind != robot::Joint::Kind::kFixed) {
      moving_.push_back(static_cast<int>(j));
    }
  }
}

std::optional<std::size_t> HandAxes::axis_named(const std::string& joint) const {
  constexpr std::string_view kPrefix = "hand_";
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (joint == joints_[i] ||
        (joint.starts_with(kPrefix) && joint.substr(kPrefix.size()) == joints_[i])) {
      return i;
    }
  }
  return std::nullopt;
}

std::string HandAxes::hint(const std::string& joint) const {
  return text::nearest_match_hint(joint, joints_);
}

std::vector<std::string> HandAxes::moving_names() const {
  std::vector<std::string> names;
  for (const int joint : moving_) {
    names.push_back("hand_" + hand_.model.joints[static_cast<std::size_t>(joint)].name);
  }
  return names;
}

std::vector<double> HandAxes::moving_values(const AxisValues& axes) const {
  Eigen::VectorXd motors(static_cast<Eigen::Index>(kAxes));
  for (std::size_t i = 0; i < kAxes; ++i) motors[actuated_[i]] = axes[i];
  const Eigen::VectorXd all = hand_.all_positions(motors);
  std::vector<double> values;
  for (const int joint : moving_) values.push_back(all[joint]);
  return values;
}

std::vector<double> HandAxes::moving_rates(const AxisValues& axes) const {
  std::vector<double> rates = moving_values(axes);
  const std::vector<double> at_rest = moving_values({});
  for (std::size_t i = 0; i < rates.size(); ++i) rates[i] -= at_rest[i];
  return rates;
}

}  // namespace prehend::drivers::sdh
