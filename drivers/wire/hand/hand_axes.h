#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/wire/hand/hand_motion.h"
#include "prehend/robot/platform.h"

namespace prehend::drivers {

/// What a device's motors can do, axis by axis, before a platform's file says what they may.
struct DeviceAxes {
  std::string a_device;         // "an SDH-2"
  std::string device;           // "SDH-2"
  std::string platform;         // that has one, for errors: "kr5_sdh"
  std::vector<double> lower;    // rad
  std::vector<double> upper;    // rad
  std::vector<double> speed;    // rad/s, most
  std::vector<double> current;  // most, A or the device's own unit: gives a joint's greatest effort
};

/// A platform's hand as a device has its axes.
class HandAxes {
 public:
  /// `joints`: the hand's actuated joints in the order of the axes.
  /// @throws geometry::InputError for a platform that moves its hand by other means, or whose hand
  /// has not these joints, or no limits of them that the device could keep.
  HandAxes(const robot::Platform& platform, const std::vector<std::string>& joints,
           const DeviceAxes& device);

  const robot::HandModel& hand() const { return hand_; }
  const std::string& device() const { return device_.device; }
  std::size_t size() const { return joints_.size(); }
  const std::vector<std::string>& joints() const { return joints_; }
  /// What file and device both allow: rad, rad/s, N m.
  double lower(std::size_t axis) const { return device_.lower[axis]; }
  double upper(std::size_t axis) const { return device_.upper[axis]; }
  double max_speed(std::size_t axis) const { return device_.speed[axis]; }
  double most_effort(std::size_t axis) const { return most_effort_[axis]; }
  template <std::size_t kCount>
  HandLimits<kCount> limits() const {
    HandLimits<kCount> limits;
    for (std::size_t i = 0; i < kCount; ++i) {
      limits.lower[i] = device_.lower.at(i);
      limits.upper[i] = device_.upper.at(i);
      limits.max_speed[i] = device_.speed.at(i);
      limits.max_current[i] = device_.current.at(i);
    }
    return limits;
  }
  double current_of(std::size_t axis, double effort) const {  // A, or the device's unit
    return effort / most_effort_[axis] * device_.current[axis];
  }
  double effort_of(std::size_t axis, double current) const {  // N m
    return current / device_.current[axis] * most_effort_[axis];
  }
  /// By the hand's name of the joint, or the platform's: with hand_ before it.
  std::optional<std::size_t> axis_named(const std::string& joint) const;
  /// ", did you mean 'pivot'?" or "".
  std::string hint(const std::string& joint) const;

  /// A joint that an axis' motor turns alone once contact holds its own (robot::Breakaway).
  struct Follower {
    std::size_t axis = 0;
    std::string joint;      // without hand_
    double ratio = 1;       // of its position to its leader's, unbroken
    double rate = 1;        // at which the motor turns it alone
    std::size_t place = 0;  // in moving_names()

    /// Where it is with the motor at `motor` [rad at the leader] and the leader at `leader`.
    double position(double motor, double leader) const {
      return rate * motor - (rate - ratio) * leader;
    }
    /// The other way round.
    double motor(double leader, double follower) const {
      return (follower + (rate - ratio) * leader) / rate;
    }
  };
  const std::vector<Follower>& followers() const { return followers_; }

  /// All joints that move, as /joint_states names them, and their positions [rad] at those of the
  /// axes: joints that follow others are among them.
  std::vector<std::string> moving_names() const;
  std::vector<double> moving_values(std::span<const double> axes) const;
  /// The same where contact holds joints: `leaders` are the axes' own joints, `axes` their motors.
  std::vector<double> moving_values(std::span<const double> axes,
                                    std::span<const double> leaders) const;
  /// The same of speeds [rad/s].
  std::vector<double> moving_rates(std::span<const double> axes) const;
  std::vector<double> moving_rates(std::span<const double> axes,
                                   std::span<const double> leaders) const;

 private:
  robot::HandModel hand_;
  std::vector<std::string> joints_;
  DeviceAxes device_;  // cut to what the file allows
  std::vector<double> most_effort_;
  std::vector<int> actuated_;  // index in hand_.actuated
  std::vector<int> moving_;    // joints of the model
  std::vector<Follower> followers_;
};

}  // namespace prehend::drivers
