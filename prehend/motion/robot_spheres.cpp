#include "prehend/motion/robot_spheres.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "prehend/geometry/kept_by_mesh.h"
#include "prehend/motion/kept_apart.h"
#include "prehend/motion/link_places.h"
#include "prehend/motion/solid_cover.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using robot::CollisionShape;

int pieces(double length, double resolution) {
  return std::max(1, static_cast<int>(std::ceil(length / resolution - 1e-9)));
}

/// Balls that hold a shape, in its own frame.
std::vector<Ball> balls_of(const CollisionShape& shape, double resolution) {
  if (shape.kind == CollisionShape::Kind::kMesh) {
    // Where links fold onto each other there are a few centimetres between them.
    static geometry::KeptByMesh<std::vector<Ball>> covers;
    return covers.of(shape.solid, resolution / 5, cover_solid);
  }
  std::vector<Ball> balls;
  if (shape.kind == CollisionShape::Kind::kSphere) return {{Vector3d::Zero(), shape.radius}};
  if (shape.kind == CollisionShape::Kind::kCylinder) {
    // Slices of a cylinder; a fine one does not need more of them than its radius asks for.
    const int count = pieces(shape.length, std::max(resolution, shape.radius));
    const double slice = shape.length / count;
    const double radius = std::hypot(shape.radius, slice / 2);
    for (int i = 0; i < count; ++i) {
      balls.push_back({{0, 0, -shape.length / 2 + (i + 0.5) * slice}, radius});
    }
    return balls;
  }
  // Cells of a box, no flatter than its flattest side.
  const double side = std::max(resolution, shape.size.minCoeff());
  const Eigen::Vector3i count(pieces(shape.size.x(), side), pieces(shape.size.y(), side),
                              pieces(shape.size.z(), side));
  const Vector3d cell = shape.size.cwiseQuotient(count.cast<double>());
  for (int z = 0; z < count.z(); ++z) {
    for (int y = 0; y < count.y(); ++y) {
      for (int x = 0; x < count.x(); ++x) {
        const Vector3d at(x + 0.5, y + 0.5, z + 0.5);
        balls.push_back({at.cwiseProduct(cell) - shape.size / 2, cell.norm() / 2});
      }
    }
  }
  return balls;
}

}  // namespace

void RobotSpheres::centers(const robot::KinematicChain& chain,
                           const Eigen::Ref<const Eigen::VectorXd>& q,
                           std::vector<Eigen::Vector3d>& centers) const {
  thread_local std::vector<RigidTransform> poses;
  chain.forward(q, poses);
  centers.resize(spheres.size());
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const RobotSphere& sphere = spheres[i];
    centers[i] = sphere.joint < 0
                     ? sphere.p_J
                     : Vector3d(poses[static_cast<std::size_t>(sphere.joint)] * sphere.p_J);
  }
}

RobotSpheres make_robot_spheres(const robot::RobotModel& model, const std::string& base,
                                const std::string& tip, double resolution,
                                const LinkPairs* may_touch) {
  if (!(resolution > 0) || !std::isfinite(resolution)) {
    throw std::invalid_argument("make_robot_spheres: resolution must be positive");
  }
  const robot::KinematicChain chain(model, base, tip);
  const auto all = link_places(model, chain, model.link_index(base));
  RobotSpheres result;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    if (!all[i]) continue;
    for (const CollisionShape& shape : model.links[i].shapes) {
      for (const Ball& ball : balls_of(shape, resolution)) {
        result.spheres.push_back({all[i]->joint, all[i]->X_JL * (shape.X_LS * ball.center),
                                  ball.radius + kBallSpare, static_cast<int>(i)});
      }
    }
  }
  std::vector<Vector3d> at;
  result.centers(chain, chain.middle(), at);
  const auto gap = [&](std::size_t a, std::size_t b) {
    return (at[a] - at[b]).norm() - result.spheres[a].radius - result.spheres[b].radius;
  };
  std::set<std::pair<int, int>> allowed;  // links
  for (const auto& [first, second] : may_touch ? *may_touch : LinkPairs()) {
    const int one = model.link_index(first), other = model.link_index(second);
    allowed.insert({std::min(one, other), std::max(one, other)});
  }
  const auto may = [&](std::size_t a, std::size_t b) {  // a < b, and so are their links
    const int apart = std::abs(result.spheres[a].joint - result.spheres[b].joint);
    if (!may_touch) return apart < 2;  // neighbours are made to touch
    return apart == 0 || allowed.contains({result.spheres[a].link, result.spheres[b].link});
  };
  for (std::size_t a = 0; a < at.size(); ++a) {
    for (std::size_t b = a + 1; b < at.size(); ++b) {
      if (may(a, b)) continue;
      if (gap(a, b) > 0) result.self_pairs.emplace_back(static_cast<int>(a), static_cast<int>(b));
    }
  }
  result.apart_pairs = kept_apart(chain, result.spheres, result.self_pairs);
  const std::set apart(result.apart_pairs.begin(), result.apart_pairs.end());
  std::erase_if(result.self_pairs, [&](const auto& pair) { return apart.contains(pair); });
  return result;
}

}  // namespace prehend::motion
