#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/motion/collision_checker.h"
#include "prehend/motion/robot_shapes.h"

namespace prehend::motion {

class CollisionWorld;

/// A robot's shapes as a checker keeps them, and which of them may not touch each other: those of
/// links with at least one other moving link between them that do not touch in the middle of the
/// limits.
class CheckedRobot {
 public:
  struct Shape {
    int joint = -1;
    geometry::RigidTransform X_JS = geometry::RigidTransform::Identity();
    ConvexBody body;
    std::unique_ptr<const CheckedBody> checked;
    Eigen::Vector3d center_S = Eigen::Vector3d::Zero();  // of a ball round all of it
    double radius = 0;                                   // m
  };

  CheckedRobot(std::shared_ptr<const CollisionChecker> checker,
               const std::vector<RobotShape>& shapes, const robot::KinematicChain& chain);

  const CollisionChecker& checker() const { return *checker_; }
  const std::vector<Shape>& shapes() const { return shapes_; }
  const std::vector<std::pair<int, int>>& self_pairs() const { return self_pairs_; }
  int joints() const { return joints_; }
  /// Farthest point of a shape from the origin of its joint's frame [m].
  static double reach(const Shape& shape);

 private:
  std::shared_ptr<const CollisionChecker> checker_;
  int joints_;
  std::vector<Shape> shapes_;
  std::vector<std::pair<int, int>> self_pairs_;
};

/// The shapes of a robot among obstacles, by a checker. Planes are tested here, exactly; what a
/// robot holds is not known here.
class ShapesInWorld {
 public:
  /// What touches first: a shape's joint, and an obstacle or another shape's joint.
  struct Touch {
    bool found = false;
    int joint = -1;
    int obstacle = -1;     // of the world's; -1: the robot itself
    int other_joint = -1;  // then
  };

  /// @param margin [m] where an obstacle has none of its own. Negative margins count as 0, but for
  /// planes and -infinity.
  /// @param before whose obstacles are taken over where they are the same; may be null.
  ShapesInWorld(std::shared_ptr<const CheckedRobot> robot, const CollisionWorld& world,
                double margin, const ShapesInWorld* before);

  const CheckedRobot& robot() const { return *robot_; }
  const std::shared_ptr<const CheckedRobot>& shared_robot() const { return robot_; }
  /// @param X_BJ poses of the frames after the joints.
  /// @param swell m for each joint, by which its shapes are larger towards obstacles; null: not.
  Touch first_touch(const std::vector<geometry::RigidTransform>& X_BJ, const double* swell) const;

 private:
  struct Obstacle {
    bool is_plane = false;
    geometry::Plane plane;
    geometry::RigidTransform X_BO = geometry::RigidTransform::Identity();
    std::shared_ptr<const std::vector<Eigen::Vector3d>> points;  // of a convex piece
    std::shared_ptr<const CheckedBody> checked;                  // not of a plane
    Eigen::Vector3d center_B = Eigen::Vector3d::Zero();          // of a ball round all of it
    double radius = 0;
    std::array<double, 2> margin{};  // of arm and hand; -infinity: may be touched
  };

  std::shared_ptr<const CheckedRobot> robot_;
  std::vector<Obstacle> obstacles_;
};

}  // namespace prehend::motion
