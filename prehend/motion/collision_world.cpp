#include "prehend/motion/collision_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "prehend/motion/convex_faces.h"

namespace prehend::motion {

using Eigen::Vector3d;
using geometry::RigidTransform;

void CollisionWorld::add_plane(const std::string& name, const geometry::Plane& plane_B) {
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.radius = std::numeric_limits<double>::infinity();
  obstacle.faces = {plane_B};
  obstacles_.push_back(std::move(obstacle));
}

void CollisionWorld::add_box(const std::string& name, const RigidTransform& X_BO,
                             const Vector3d& size) {
  if (!(size.minCoeff() > 0) || !size.allFinite() || !X_BO.matrix().allFinite()) {
    throw std::invalid_argument("CollisionWorld: box '" + name + "' needs positive, finite sides");
  }
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.kind = Obstacle::Kind::kBox;
  obstacle.X_OB = X_BO.inverse();
  obstacle.half = size / 2;
  obstacle.center = X_BO.translation();
  obstacle.radius = size.norm() / 2;
  const Vector3d half_B = X_BO.linear().cwiseAbs() * obstacle.half;
  obstacle.bounds = {obstacle.center - half_B, obstacle.center + half_B};
  obstacles_.push_back(std::move(obstacle));
}

void CollisionWorld::add_sphere(const std::string& name, const Vector3d& center_B, double radius) {
  if (!(radius > 0) || !std::isfinite(radius) || !center_B.allFinite()) {
    throw std::invalid_argument("CollisionWorld: sphere '" + name + "' needs a positive radius");
  }
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.kind = Obstacle::Kind::kSphere;
  obstacle.center = center_B;
  obstacle.radius = radius;
  obstacle.bounds = {center_B - Vector3d::Constant(radius), center_B + Vector3d::Constant(radius)};
  obstacles_.push_back(std::move(obstacle));
}

void CollisionWorld::add_convex(const std::string& name, const geometry::TriangleMesh& mesh_B) {
  ConvexFaces convex = convex_faces(name, mesh_B);
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.kind = Obstacle::Kind::kConvex;
  obstacle.center = convex.bounds.center();
  obstacle.radius = convex.radius;
  obstacle.bounds = convex.bounds;
  obstacle.faces = std::move(convex.faces);
  obstacle.points = std::make_shared<const std::vector<Vector3d>>(std::move(convex.points));
  obstacles_.push_back(std::move(obstacle));
}

bool CollisionWorld::remove(const std::string& name) {
  return std::erase_if(obstacles_, [&](const Obstacle& o) { return o.name == name; }) > 0;
}

double CollisionWorld::distance(const Obstacle& obstacle, const Vector3d& p_B, double enough) {
  switch (obstacle.kind) {
    case Obstacle::Kind::kSphere:
      return (p_B - obstacle.center).norm() - obstacle.radius;
    case Obstacle::Kind::kBox: {
      const Vector3d beyond = (obstacle.X_OB * p_B).cwiseAbs() - obstacle.half;
      return beyond.cwiseMax(0).norm() + std::min(0.0, beyond.maxCoeff());
    }
    default: {
      double most = -std::numeric_limits<double>::infinity();
      for (const geometry::Plane& face : obstacle.faces) {
        most = std::max(most, face.signed_distance(p_B));
        if (most >= enough) break;
      }
      return most;
    }
  }
}

double CollisionWorld::clearance(const Vector3d& center_B, double radius,
                                 std::string* nearest) const {
  double least = kInfinity;
  for (const Obstacle& obstacle : obstacles_) {
    const double gap = distance(obstacle, center_B, least + radius) - radius;
    if (gap >= least) continue;
    least = gap;
    if (nearest) *nearest = obstacle.name;
  }
  return least;
}

bool CollisionWorld::set_margin(const std::string& name, Part part, double margin) {
  if (std::isnan(margin)) throw std::invalid_argument("CollisionWorld: a margin is not a number");
  bool found = false;
  for (Obstacle& obstacle : obstacles_) {
    if (obstacle.name != name) continue;
    obstacle.margin[static_cast<std::size_t>(part)] = margin;
    found = true;
  }
  return found;
}

bool CollisionWorld::touches(const Vector3d& center_B, double radius, double margin, Part part,
                             std::string* touched) const {
  double deepest = 0;
  for (const Obstacle& obstacle : obstacles_) {
    const double reach = radius + obstacle.margin_for(part, margin);
    const double far = std::max(0.0, reach);
    if (obstacle.kind != Obstacle::Kind::kPlane &&
        obstacle.bounds.squaredExteriorDistance(center_B) > far * far) {
      continue;
    }
    const double depth = reach - distance(obstacle, center_B, reach - deepest);
    if (!(depth > deepest)) continue;
    if (!touched) return true;
    deepest = depth;
    *touched = obstacle.name;
  }
  return deepest > 0;
}

std::vector<std::string> CollisionWorld::names() const {
  std::vector<std::string> names;
  for (const Obstacle& obstacle : obstacles_) {
    if (std::find(names.begin(), names.end(), obstacle.name) == names.end()) {
      names.push_back(obstacle.name);
    }
  }
  return names;
}

double CollisionWorld::clearance_from(const std::string& name, const Vector3d& center_B,
                                      double radius) const {
  double least = kInfinity;
  for (const Obstacle& obstacle : obstacles_) {
    if (obstacle.name != name) continue;
    // Of what is farther than the nearest so far, not even the faces are asked.
    const double far = obstacle.radius + radius + least;
    if (far > 0 && (center_B - obstacle.center).squaredNorm() >= far * far) continue;
    least = std::min(least, distance(obstacle, center_B, least + radius) - radius);
  }
  return least;
}

Part part_of_ball(const RobotSphere& ball, bool is_held, int joints) {
  if (is_held) return Part::kHeld;
  return ball.joint == joints - 1 ? Part::kHand : Part::kArm;
}

}  // namespace prehend::motion
