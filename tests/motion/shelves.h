#pragma once

#include <numbers>
#include <vector>

#include "prehend/robot/inverse_kinematics.h"
#include "tests/motion/fcl_oracle.h"
#include "tests/robot/arms.h"

namespace prehend::motion {

inline geometry::RigidTransform at(double x, double y, double z) {
  return geometry::RigidTransform(Eigen::Translation3d(x, y, z));
}

/// A PA10 on a table with shelves in front of it.
struct Shelves {
  robot::RobotModel model = robot::read_urdf("config/robots/pa10_7c.urdf");
  robot::KinematicChain chain = robot::pa10();
  FclOracle oracle{model, chain};
  CollisionWorld world;

  Shelves() {
    add({0.75, 0, 0.25}, {0.4, 0.9, 0.03});
    add({0.75, 0, 0.75}, {0.4, 0.9, 0.03});
    add({0.75, 0.45, 0.5}, {0.4, 0.03, 0.53});
    add({0.75, -0.45, 0.5}, {0.4, 0.03, 0.53});
    add({0.75, 0, 0.5}, {0.4, 0.03, 0.53});  // between two compartments
  }
  void add(const Eigen::Vector3d& center, const Eigen::Vector3d& size) {
    const geometry::RigidTransform X = at(center.x(), center.y(), center.z());
    world.add_box("shelf", X, size);
    oracle.add_box(X, size);
  }
  RobotInWorld in_world() const {
    return {chain, make_robot_spheres(model, "base_link", "tool0", 0.05), world, 0.005};
  }
  /// Free positions with the flange at p, pointing forward.
  std::vector<robot::Positions> reach(const RobotInWorld& in_world,
                                      const Eigen::Vector3d& p) const {
    const robot::InverseKinematics inverse(chain, {.elbow_angles = 24});
    geometry::RigidTransform X = at(p.x(), p.y(), p.z());
    X.linear() =
        Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()).toRotationMatrix();
    std::vector<robot::Positions> result;
    for (const robot::Positions& q : inverse.solve(X).solutions) {
      if (in_world.is_free(q)) result.push_back(q);
    }
    return result;
  }
};

}  // namespace prehend::motion
