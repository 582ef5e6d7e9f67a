#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "drivers/sdh/driver/driver.h"
#include "prehend/robot/platform.h"

namespace prehend::drivers::sdh {

/// Of config/robots/sdh2.yaml, in the order of the axes. Which of the fingers 1 and 3 of the
/// vendor's library is which is not published beyond the names that ipa320's schunk_sdh gives them.
inline const std::vector<std::string> kSdh2Axes{
    "pivot",        "finger_1_proximal", "finger_1_distal", "thumb_proximal",
    "thumb_distal", "finger_2_proximal", "finger_2_distal"};

/// A platform's hand as an SDH-2 has its axes.
class HandAxes {
 public:
  /// `joints`: the hand's actuated joints in the order of the axes. `most_current` [A] gives a
  /// joint's greatest effort; what the motors give is not published.
  /// @throws geometry::InputError for a platform that moves its hand by other means, or whose hand
  /// has not these seven joints, or no limits of them that an SDH-2 could keep.
  HandAxes(const robot::Platform& platform, const std::vector<std::string>& joints,
           double most_current);

  const robot::HandModel& hand() const { return hand_; }
  const std::vector<std::string>& joints() const { return joints_; }
  /// What the file and the vendor's library both allow.
  const Limits& limits() const { return limits_; }
  double most_effort(std::size_t axis) const { return most_effort_[axis]; }  // N m
  double current_of(std::size_t axis, double effort) const {                 // A
    return effort / most_effort_[axis] * most_current_;
  }
  double effort_of(std::size_t axis, double current) const {  // N m
    return current / most_current_ * most_effort_[axis];
  }
  /// By the hand's name of the joint, or the platform's: with hand_ before it.
  std::optional<std::size_t> axis_named(const std::string& joint) const;
  /// ", did you mean 'pivot'?" or "".
  std::string hint(const std::string& joint) const;

  /// All joints that move, as /joint_states names them, and their positions [rad] at those of the
  /// axes: joints that follow others are among them.
  std::vector<std::string> moving_names() const;
  std::vector<double> moving_values(const AxisValues& axes) const;
  /// The same of speeds [rad/s].
  std::vector<double> moving_rates(const AxisValues& axes) const;

 private:
  robot::HandModel hand_;
  std::vector<std::string> joints_;
  double most_current_;
  Limits limits_;
  AxisValues most_effort_{};
  std::array<int, kAxes> actuated_{};  // index in hand_.actuated
  std::vector<int> moving_;            // joints of the model
};

}  // namespace prehend::drivers::sdh
