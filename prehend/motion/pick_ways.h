#pragma once

#include <functional>
#include <string>
#include <vector>

#include "prehend/motion/path_planner.h"
#include "prehend/motion/pick_ledger.h"
#include "prehend/motion/pick_scenes.h"

namespace prehend::motion {

/// A pose further by a way in the base's frame [m].
geometry::RigidTransform moved_by(const geometry::RigidTransform& X_BT,
                                  const Eigen::Vector3d& by_B);

/// From above a place to beside it.
struct WayDown {
  std::vector<robot::Positions> down, retreat;
  geometry::RigidTransform X_BO;  // of the object where it is to stand, by its shape
  robot::Positions stands;        // when it is there
};

/// The straight ways of a pick: to a grasp, up with the object, down to a place and back. Refers to
/// what it is made of.
class PickWays {
 public:
  PickWays(const PickScenes& scenes, const robot::InverseKinematics& inverse, const PickTask& task,
           const PickOptions& options)
      : scenes_(scenes), inverse_(inverse), task_(task), options_(options) {}

  /// straight_path() of the tip by PickOptions::straight_step.
  JointPath straight(const RobotInWorld& scene, const robot::Positions& from,
                     const geometry::RigidTransform& X_BT) const;

  struct Raised {
    JointPath up;
    std::string problem;  // what is carried touches there; "": nothing
  };
  /// Straight up from `q`: until the object is clear_height over where it was picked, else by
  /// lift_height, or by as much more as what is held needs to clear what stands about it; by
  /// lift_height where more does not help.
  /// @param rise m, of the object at `q` over where it was picked. @param carry what must be free
  /// there; null: nothing.
  Raised raised(const RobotInWorld& scene, const robot::Positions& q,
                const geometry::RigidTransform& X_BT, double rise, const RobotInWorld* carry) const;

  /// Adds ways down to a place and back, four at most, until it `is_over`; the farthest miss when
  /// there are none. The object ends higher than X_BO_place where the hand has no room to be so
  /// low, and the way goes on below with PickTask::goes_on_down.
  /// @param seed positions that solutions are to be near. @param carry with the object held.
  PickMiss down(const PickGrasp& grasp, const robot::Positions& seed,
                const geometry::RigidTransform& X_BO_place, const RobotInWorld& carry,
                const std::function<bool()>& is_over, std::vector<WayDown>* ways) const;

 private:
  std::vector<robot::Positions> on_down(const robot::Positions& q,
                                        const geometry::RigidTransform& X_BT, double length) const;
  std::string sinks_in(const RobotInWorld& carry, const robot::Positions& q) const;

  const PickScenes& scenes_;
  const robot::InverseKinematics& inverse_;
  const PickTask& task_;
  const PickOptions& options_;
};

}  // namespace prehend::motion
