#include "prehend/control/moved_grasps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace prehend::control {
namespace {

using geometry::RigidTransform;

void move_points(const RigidTransform& X, std::vector<Eigen::Vector3d>* points) {
  for (Eigen::Vector3d& p : *points) p = X * p;
}

/// Between the pads, or the hand's origin where no contact is told.
Eigen::Vector3d middle_of_contacts(const grasp::Grasp& grasp) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto count = grasp.left_contacts_W.size() + grasp.right_contacts_W.size();
  if (count == 0) return grasp.X_WG.translation();
  for (const auto& p : grasp.left_contacts_W) sum += p;
  for (const auto& p : grasp.right_contacts_W) sum += p;
  return sum / static_cast<double>(count);
}

grasp::Grasp moved(const grasp::Grasp& grasp, const RigidTransform& X) {
  grasp::Grasp result = grasp;
  result.X_WG = X * grasp.X_WG;
  result.approach_W = X.linear() * grasp.approach_W;
  move_points(X, &result.left_contacts_W);
  move_points(X, &result.right_contacts_W);
  return result;
}

/// Turned about the middle of its contacts until it approaches along `approach_W` again.
grasp::Grasp straightened(const grasp::Grasp& grasp, const Eigen::Vector3d& approach_W) {
  const Eigen::Vector3d pivot = middle_of_contacts(grasp);
  RigidTransform turn = RigidTransform::Identity();
  turn.linear() =
      Eigen::Quaterniond::FromTwoVectors(grasp.approach_W, approach_W).toRotationMatrix();
  turn.translation() = pivot - turn.linear() * pivot;
  grasp::Grasp result = grasp;
  result.X_WG = turn * grasp.X_WG;
  result.approach_W = approach_W;
  return result;
}

bool within(const Eigen::AlignedBox3d& box, const grasp::Grasp& grasp) {
  const Eigen::Vector3d p = grasp.X_WG.translation();
  return box.isEmpty() ||
         (box.contains(p) && box.contains(p - grasp.pregrasp_distance * grasp.approach_W));
}

}  // namespace

MovedGrasps moved_grasps(const std::vector<grasp::Grasp>& grasps, const RigidTransform& X_moved,
                         const MovedGraspLimits& limits) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  MovedGrasps result;
  if (grasps.empty()) {
    result.problem = "no grasp of the plan is left";
    return result;
  }
  const Eigen::Vector3d up_now = X_moved.linear() * limits.up_W;
  const double tilt = std::acos(std::clamp(up_now.dot(limits.up_W), -1.0, 1.0));
  if (!(tilt <= limits.largest_tilt)) {
    result.problem =
        fmt::format("the object has tipped by {:.0f} deg since it was planned on", tilt * kDegrees);
    return result;
  }
  const Eigen::Vector3d before = middle_of_contacts(grasps.front());
  const double drop = limits.up_W.dot(before - X_moved * before);
  if (!(drop <= limits.largest_drop)) {
    result.problem =
        fmt::format("the object lies {:.0f} mm lower than where it was planned on", 1e3 * drop);
    return result;
  }
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    const grasp::Grasp& grasp = grasps[i];
    grasp::Grasp now = moved(grasp, X_moved);
    // A turn about the vertical turns approaches from the side along: the carrier cannot.
    const double cosine = std::clamp(now.approach_W.dot(grasp.approach_W), -1.0, 1.0);
    if (std::acos(cosine) > limits.largest_tilt) continue;
    now = straightened(now, grasp.approach_W);
    if (!within(limits.workspace_W, now)) continue;
    result.grasps.push_back(std::move(now));
    result.indices.push_back(i);
  }
  if (result.grasps.empty()) {
    result.problem = "no grasp of the plan is within the carrier's reach where the object is now";
  }
  return result;
}

}  // namespace prehend::control
