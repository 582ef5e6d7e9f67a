#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "prehend/robot/platform.h"
#include "prehend/touch/grasp_stability.h"

namespace prehend::control {

struct ArmPercepts;

/// m, that the hand has risen by when it is asked for the second time whether the lift holds:
/// touch::GripMoment::kLifting.
inline constexpr double kAskedWhenRisen = 0.01;

/// What the pads of a hand that stands so feel. @param hand_joints, hand_positions that its port
/// says, besides those of `percepts`. @throws as touch::HandTouch::contacts().
touch::Grip felt_grip(const touch::HandTouch& hand, const ArmPercepts& percepts,
                      const std::vector<std::string>& hand_joints,
                      const std::vector<double>& hand_positions);

/// Judges a platform's grip in a cycle by what its pads feel: how likely the lift holds, when the
/// hand has closed and again when it has risen by kAskedWhenRisen.
class GripJudge {
 public:
  GripJudge(const robot::Platform& platform, touch::GraspStability model);
  /// By config/touch/grasp_stability.yaml. @throws geometry::InputError as GraspStability::load().
  explicit GripJudge(const robot::Platform& platform);
  /// None for a hand without pads.
  static std::optional<GripJudge> of(const robot::Platform& platform);

  /// The hand has closed. Unset: no pad touches, or it is not known how the hand stands.
  std::optional<double> closed(const ArmPercepts& percepts,
                               const std::vector<std::string>& hand_joints,
                               const std::vector<double>& hand_positions);
  /// After closed(): the same grip if it were pressed so many times as hard. @pre closed() was set
  double if_pressed(double factor) const;
  /// The hand rises. Set once after each closed() that was set.
  std::optional<double> lifting(const ArmPercepts& percepts,
                                const std::vector<std::string>& hand_joints,
                                const std::vector<double>& hand_positions);

 private:
  std::optional<touch::Grip> felt(const ArmPercepts& percepts,
                                  const std::vector<std::string>& hand_joints,
                                  const std::vector<double>& hand_positions) const;
  std::optional<double> height(const ArmPercepts& percepts) const;  // m, of the flange

  touch::HandTouch touch_;
  robot::KinematicChain chain_;
  geometry::RigidTransform X_WB_;
  touch::GraspStability model_;
  std::optional<touch::Grip> closed_;
  std::optional<double> start_;  // m, height of the flange when it had closed; unset: asked
};

}  // namespace prehend::control
