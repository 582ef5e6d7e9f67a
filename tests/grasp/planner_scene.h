#pragma once

#include <Eigen/Geometry>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/grasp/planner.h"

/// What tests of the planner with a parallel gripper share.
namespace prehend::grasp::testing {

inline const robot::GripperModel kPlannerGripper;

inline surface::ObjectModel object_at(const geometry::TriangleMesh& mesh, const Eigen::Vector3d& p,
                                      double yaw = 0) {
  surface::ObjectModel object;
  object.mesh_W = geometry::transformed(
      mesh, geometry::make_transform(
                Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), p));
  return object;
}

inline Reachability carrier() {
  Reachability reachability;
  reachability.approach_W = -Eigen::Vector3d::UnitZ();
  return reachability;
}

}  // namespace prehend::grasp::testing
