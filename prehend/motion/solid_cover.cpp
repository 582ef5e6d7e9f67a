#include "prehend/motion/solid_cover.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;

constexpr std::size_t kMostBalls = 20000;
constexpr double kRoundingUp = 1e-7;  // m, on every radius: queries are in single precision

/// The parts of a convex polygon on either side of a plane across `axis`.
std::pair<Polygon, Polygon> halves(const Polygon& polygon, int axis, double limit) {
  std::pair<Polygon, Polygon> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d& a = polygon[i];
    const Vector3d& b = polygon[(i + 1) % polygon.size()];
    const double of_a = a[axis] - limit, of_b = b[axis] - limit;
    if (of_a <= 0) result.first.push_back(a);
    if (of_a >= 0) result.second.push_back(a);
    if ((of_a < 0 && of_b > 0) || (of_a > 0 && of_b < 0)) {
      const Vector3d between = a + of_a / (of_a - of_b) * (b - a);
      result.first.push_back(between);
      result.second.push_back(between);
    }
  }
  return result;
}

class SolidCover {
 public:
  SolidCover(const geometry::TriangleMesh& solid, double overshoot)
      : query_(solid), overshoot_(overshoot) {
    std::vector<Polygon> surface;
    for (const Eigen::Vector3i& t : solid.triangles) {
      surface.push_back({solid.vertices[t.x()], solid.vertices[t.y()], solid.vertices[t.z()]});
    }
    cover(surface, query_.box());
  }

  std::vector<Ball> balls() && { return std::move(balls_); }

 private:
  /// Covers what of the solid is in `box`, where its surface is `surface`.
  void cover(const std::vector<Polygon>& surface, const Eigen::AlignedBox3d& box) {
    // It is in the hull of these: the surface's corners, and the box's that are inside.
    Polygon points;
    for (const Polygon& polygon : surface) {
      points.insert(points.end(), polygon.begin(), polygon.end());
    }
    for (int k = 0; k < 8; ++k) {
      const Vector3d corner = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
      if (query_.contains(corner)) points.push_back(corner);
    }
    if (points.empty()) return;
    Eigen::AlignedBox3d filled;
    for (const Vector3d& p : points) filled.extend(p);
    Ball ball{filled.center(), 0};
    for (const Vector3d& p : points) {
      ball.radius = std::max(ball.radius, (p - ball.center).norm());
    }
    ball.radius += kRoundingUp;
    // A ball about the centre that is all inside takes its radius from what is outside.
    if (ball.radius + query_.signed_distance(ball.center) <= overshoot_ ||
        ball.radius <= overshoot_ / 2) {
      add(ball);
      return;
    }
    int axis = 0;
    filled.sizes().maxCoeff(&axis);
    const double middle = ball.center[axis];
    std::vector<Polygon> low, high;
    for (const Polygon& polygon : surface) {
      auto [below, above] = halves(polygon, axis, middle);
      if (!below.empty()) low.push_back(std::move(below));
      if (!above.empty()) high.push_back(std::move(above));
    }
    Eigen::AlignedBox3d half = filled;
    half.max()[axis] = middle;
    cover(low, half);
    half = filled;
    half.min()[axis] = middle;
    cover(high, half);
  }

  void add(const Ball& ball) {
    if (balls_.size() == kMostBalls) {
      throw geometry::InputError("A solid of " + std::to_string(query_.box().sizes().maxCoeff()) +
                                     " m needs more than 20000 balls to reach at most " +
                                     std::to_string(overshoot_) + " m beyond it",
                                 "Take a coarser resolution");
    }
    balls_.push_back(ball);
  }

  geometry::MeshQuery query_;
  double overshoot_;
  std::vector<Ball> balls_;
};

}  // namespace

std::vector<Ball> cover_solid(const geometry::TriangleMesh& solid, double overshoot) {
  if (!(overshoot > 0) || !std::isfinite(overshoot)) {
    throw std::invalid_argument("cover_solid: the overshoot must be positive");
  }
  return SolidCover(solid, overshoot).balls();
}

}  // namespace prehend::motion
