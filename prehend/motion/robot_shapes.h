#pragma once

#include <string>
#include <vector>

#include "prehend/motion/collision_checker.h"
#include "prehend/robot/kinematic_chain.h"

namespace prehend::motion {

/// A collision shape of a link.
struct RobotShape {
  int joint = -1;  // of the chain, that moves it; -1: stands with the base
  geometry::RigidTransform X_JS = geometry::RigidTransform::Identity();  // after that joint
  ConvexBody body;
};

/// The shapes that make_robot_spheres() covers with balls, as they are; of meshes the convex hulls.
/// @throws geometry::InputError for a mesh without volume, and as KinematicChain.
std::vector<RobotShape> make_robot_shapes(const robot::RobotModel& model, const std::string& base,
                                          const std::string& tip);

}  // namespace prehend::motion
