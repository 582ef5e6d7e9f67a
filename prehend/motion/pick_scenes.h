#pragma once

#include <optional>
#include <vector>

#include "prehend/motion/pick_motion.h"

namespace prehend::motion {

/// The robot's world in the phases of a pick: who may touch what.
class PickScenes {
 public:
  PickScenes(const RobotInWorld& robot, const PickTask& task);

  /// Nothing may touch.
  const RobotInWorld& reach() const { return reach_; }
  /// The hand may touch the object.
  const RobotInWorld& approach() const { return approach_; }
  /// The object moves with the hand, held as `grasp` does.
  RobotInWorld carry(const PickGrasp& grasp) const;
  /// As carry(), but what is held may stay as near to each thing as it is at `q`, and where it
  /// overlaps with one there may do so twice as much: shapes are wrong by so much at least.
  RobotInWorld lift(const PickGrasp& grasp, const robot::Positions& q) const;
  /// The object stands at X_BO and the hand may touch it.
  RobotInWorld retreat(const geometry::RigidTransform& X_BO) const;

  /// Pose of the tip when the object is at X_BO.
  geometry::RigidTransform X_BT_at(const PickGrasp& grasp,
                                   const geometry::RigidTransform& X_BO) const;
  /// The approach's direction there.
  Eigen::Vector3d approach_at(const PickGrasp& grasp, const geometry::RigidTransform& X_BO) const;

 private:
  /// Lets the hand be at what it may touch, or keeps clear of by itself.
  void let_hand(CollisionWorld& world) const;
  /// The object's balls in the tip's frame.
  std::vector<RobotSphere> held(const PickGrasp& grasp) const;

  const PickTask& task_;
  RobotInWorld reach_, approach_, without_;
};

}  // namespace prehend::motion
