#pragma once

#include <limits>
#include <optional>

#include "prehend/geometry/plane.h"
#include "prehend/grasp/closing/distance_grid.h"
#include "prehend/grasp/closing/hand_balls.h"

namespace prehend::grasp {

/// What a hand can touch.
enum class Touched { kNothing, kObject, kTable, kObstacle };

/// The object to be grasped, the table under it and other things, for balls to touch. Refers to
/// what it is given.
struct TouchScene {
  const DistanceGrid* object_W = nullptr;     // none: no object
  std::optional<geometry::Plane> table_W;     // solid below
  const DistanceGrid* obstacles_W = nullptr;  // none: no others

  /// Distance of the nearest of them, see DistanceGrid::distance(), and which it is.
  double distance(const Eigen::Vector3d& p_W, Touched* what = nullptr) const;
  /// Distance of the named one without interpolation, and the direction away from it (unit, 0 where
  /// it is undefined).
  double exact_distance(const Eigen::Vector3d& p_W, Touched what, Eigen::Vector3d* away_W) const;
};

/// A ball of a link that is near something.
struct NearBall {
  double clearance = std::numeric_limits<double>::infinity();  // m, negative when they overlap
  int ball = -1;                                               // of the link
  Touched what = Touched::kNothing;
};

constexpr double kExact = 1e-3;  // m, of clearances

/// The link's ball that is nearest to anything in the scene, or, where all are farther than `exact`
/// [m], a lower bound of its clearance, above `exact` (with a ball that is about as near). Where
/// `exact` and a ball's radius together are more than DistanceGrid::kNear it can be too small.
/// `likely`: a ball that may well be the nearest, as it was one before (none: -1): it saves much.
NearBall nearest_ball(const LinkBalls& link, const geometry::RigidTransform& X_WL,
                      const TouchScene& scene, double exact = kExact, int likely = -1);

/// The link's ball that is lowest over a plane, and by how much it clears it; none (-1) when all
/// clear it by `most` [m] or more.
NearBall lowest_ball(const LinkBalls& link, const geometry::RigidTransform& X_WL,
                     const geometry::Plane& plane_W,
                     double most = std::numeric_limits<double>::infinity());

/// Calls visit(ball, p_W, clearance) for each ball of the link nearer to the object than `depth`.
template <class Visit>
void each_near_ball(const LinkBalls& link, const geometry::RigidTransform& X_WL,
                    const DistanceGrid& object_W, double depth, Visit visit, int node = 0) {
  if (link.nodes.empty()) return;
  const LinkBalls::Node& here = link.nodes[static_cast<std::size_t>(node)];
  if (object_W.distance(X_WL * here.center) - here.radius > depth) return;
  if (!here.leaf()) {
    each_near_ball(link, X_WL, object_W, depth, visit, here.first);
    each_near_ball(link, X_WL, object_W, depth, visit, here.right);
    return;
  }
  for (int i = here.first; i < here.last; ++i) {
    const Eigen::Vector3d p_W = X_WL * link.centers[static_cast<std::size_t>(i)];
    const double clearance = object_W.distance(p_W) - link.radii[static_cast<std::size_t>(i)];
    if (clearance <= depth) visit(i, p_W, clearance);
  }
}

}  // namespace prehend::grasp
