#include "drivers/wire/hand/hand_axes.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/text/nearest_match.h"

namespace prehend::drivers {
namespace {

constexpr std::string_view kOfHand = "hand_";  // before the names of a platform's hand

}  // namespace

HandAxes::HandAxes(const robot::Platform& platform, const std::vector<std::string>& joints,
                   const DeviceAxes& device)
    : hand_(platform.hand), joints_(joints), device_(device) {
  const std::size_t count = device.lower.size();
  const bool has_joints = platform.hand_port == robot::HandPort::kJoints;
  if (!has_joints || hand_.actuated.size() != count) {
    throw geometry::InputError(
        has_joints ? fmt::format("the hand of platform {} has {} motors, {} has {}", platform.name,
                                 hand_.actuated.size(), device.a_device, count)
                   : fmt::format("platform {} has a gripper, moved through /gripper, and no {}",
                                 platform.name, device.device),
        fmt::format("Name a platform with {}, platform:={}", device.a_device, device.platform));
  }
  if (joints.size() != count) {
    throw geometry::InputError(
        fmt::format("{} names for the {} axes of {}", joints.size(), count, device.a_device),
        "Give axes:= the hand's joints in the order of the axes");
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (std::ranges::count(joints, joints[i]) > 1) {
      throw geometry::InputError("axis '" + joints[i] + "' is named twice",
                                 "Give each of the hand's joints one place in axes");
    }
    actuated_.push_back(hand_.actuated_index(joints[i]));
    const int own = hand_.actuated[static_cast<std::size_t>(actuated_.back())];
    const robot::Joint& joint = hand_.model.joints[static_cast<std::size_t>(own)];
    device_.lower[i] = std::max(device.lower[i], joint.lower);
    device_.upper[i] = std::min(device.upper[i], joint.upper);
    device_.speed[i] = std::min(device.speed[i], joint.max_velocity);
    most_effort_.push_back(joint.max_effort);
    const bool can_be = device_.lower[i] < device_.upper[i] && std::isfinite(joint.max_effort) &&
                        joint.max_effort > 0 && device_.speed[i] > 0;
    if (!can_be) {
      throw geometry::InputError(
          fmt::format("joint '{}' of platform {} has no limits that axis {} of {} could keep",
                      joints[i], platform.name, i, device.a_device),
          "Its URDF needs limits of position, velocity and effort within those of the axis");
    }
  }
  for (std::size_t j = 0; j < hand_.model.joints.size(); ++j) {
    if (hand_.model.joints[j].kind != robot::Joint::Kind::kFixed) {
      moving_.push_back(static_cast<int>(j));
    }
  }
  for (const robot::Breakaway& breakaway : hand_.breakaways) {
    const robot::Joint& joint = hand_.model.joints[static_cast<std::size_t>(breakaway.joint)];
    Follower follower;
    follower.joint = joint.name;
    follower.ratio = joint.mimic->multiplier;
    follower.rate = breakaway.rate;
    follower.place =
        static_cast<std::size_t>(std::ranges::find(moving_, breakaway.joint) - moving_.begin());
    for (std::size_t i = 0; i < count; ++i) {
      if (hand_.actuated[static_cast<std::size_t>(actuated_[i])] == breakaway.leader) {
        follower.axis = i;
      }
    }
    followers_.push_back(follower);
  }
}

std::optional<std::size_t> HandAxes::axis_named(const std::string& joint) const {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    if (joint == joints_[i] ||
        (joint.starts_with(kOfHand) && joint.substr(kOfHand.size()) == joints_[i])) {
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
    names.push_back(std::string(kOfHand) +
                    hand_.model.joints[static_cast<std::size_t>(joint)].name);
  }
  return names;
}

std::vector<double> HandAxes::moving_values(std::span<const double> axes) const {
  Eigen::VectorXd motors(static_cast<Eigen::Index>(actuated_.size()));
  for (std::size_t i = 0; i < actuated_.size(); ++i) motors[actuated_[i]] = axes[i];
  const Eigen::VectorXd all = hand_.all_positions(motors);
  std::vector<double> values;
  for (const int joint : moving_) values.push_back(all[joint]);
  return values;
}

std::vector<double> HandAxes::moving_values(std::span<const double> axes,
                                            std::span<const double> leaders) const {
  std::vector<double> values = moving_values(leaders);
  for (const Follower& follower : followers_) {
    values[follower.place] = follower.position(axes[follower.axis], leaders[follower.axis]);
  }
  return values;
}

std::vector<double> HandAxes::moving_rates(std::span<const double> axes) const {
  std::vector<double> rates = moving_values(axes);
  const std::vector<double> at_rest = moving_values(std::vector<double>(actuated_.size(), 0.0));
  for (std::size_t i = 0; i < rates.size(); ++i) rates[i] -= at_rest[i];
  return rates;
}

std::vector<double> HandAxes::moving_rates(std::span<const double> axes,
                                           std::span<const double> leaders) const {
  std::vector<double> rates = moving_rates(leaders);
  for (const Follower& follower : followers_) {
    rates[follower.place] = follower.position(axes[follower.axis], leaders[follower.axis]);
  }
  return rates;
}

}  // namespace prehend::drivers
