#include "prehend/grasp/closing/solid_balls.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>

#include "prehend/geometry/mesh_query.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using CellKey = std::array<std::int64_t, 3>;

constexpr double kHeld = 0.25;       // of the dip: half of the tolerance, as points tried are apart
constexpr double kPointShare = 0.3;  // of a ball's reach along a face, between points tried
constexpr double kLeastShare = 0.03;    // of the inset: smaller balls are left out
constexpr double kSmaller = 0.9;        // a ball so much smaller than its neighbour is at an edge
constexpr double kEdgeRounding = 0.75;  // radii that a corner may stick out: sqrt(3) - 1, and a bit
constexpr int kShrinkSteps = 20;

CellKey key_of(const Vector3d& p, double side) {
  CellKey key{};
  for (int k = 0; k < 3; ++k) key[k] = static_cast<std::int64_t>(std::floor(p[k] / side));
  return key;
}

/// A place of the surface, and the largest ball that touches it there from within.
struct Place {
  Vector3d point, normal;
  SolidBall ball;
};

class SolidCover {
 public:
  SolidCover(const geometry::TriangleMesh& solid, double tolerance)
      : solid_(solid),
        query_(solid),
        tolerance_(tolerance),
        inset_(ball_inset(query_.box().sizes().minCoeff())) {}

  std::vector<SolidBall> balls() {
    find_places();
    std::vector<std::size_t> order(places_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return places_[a].ball.radius > places_[b].ball.radius;
    });
    for (const std::size_t i : order) {
      if (!is_held(places_[i])) take(places_[i].ball);
    }
    return std::move(taken_);
  }

 private:
  double dip(double radius) const { return std::min(2 * tolerance_, radius / 2); }

  /// Points of all triangles, evenly spread.
  void find_places() {
    // Along a face, a ball's top is within the tolerance as far as this.
    const double radius = inset_ + dip(inset_) / 2, low = inset_ - dip(inset_) / 2;
    const double spacing = kPointShare * std::sqrt(radius * radius - low * low);
    std::set<CellKey> seen;
    for (const Eigen::Vector3i& t : solid_.triangles) {
      const Vector3d &a = solid_.vertices[t.x()], &b = solid_.vertices[t.y()],
                     &c = solid_.vertices[t.z()];
      const Vector3d across = (b - a).cross(c - a);
      if (!(across.norm() > 0)) continue;
      const Vector3d normal = across.normalized();
      const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
      const int parts = std::max(1, static_cast<int>(std::ceil(longest / spacing)));
      // Middles of parts, not their corners: at an edge the normal is of either side.
      for (int i = 0; i < parts; ++i) {
        for (int j = 0; i + j < parts; ++j) {
          const double u = (i + 1.0 / 3) / parts, v = (j + 1.0 / 3) / parts;
          const Vector3d p = a + u * (b - a) + v * (c - a);
          if (!seen.insert(key_of(p, spacing)).second) continue;
          const SolidBall ball = largest_ball(p, normal);
          if (ball.radius > kLeastShare * inset_) places_.push_back({p, normal, ball});
        }
      }
    }
  }

  SolidBall largest_ball(const Vector3d& p, const Vector3d& normal) const {
    constexpr double kTouching = 1e-3;  // of the radius
    SolidBall ball{p - inset_ * normal, inset_};
    for (int step = 0; step < kShrinkSteps; ++step) {
      const auto nearest = query_.nearest(ball.center, ball.radius * (1 - kTouching));
      if (!nearest) return ball;
      // The ball that touches at p and passes through the nearer point.
      const Vector3d to = p - nearest->point;
      const double along = normal.dot(to);
      if (!(along > 0)) break;
      const double radius = std::min(ball.radius * (1 - kTouching), to.squaredNorm() / (2 * along));
      ball = {p - radius * normal, radius};
    }
    ball.radius = 0;
    return ball;
  }

  bool is_held(const Place& place) const {
    const CellKey at = key_of(place.point, side());
    for (int n = 0; n < 27; ++n) {
      const auto cell = cells_.find({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1});
      if (cell == cells_.end()) continue;
      for (const std::size_t k : cell->second) {
        const SolidBall& ball = taken_[k];
        const Vector3d from = place.point - ball.center;
        const double rise = place.normal.dot(from);
        const double left = ball.radius * ball.radius - (from.squaredNorm() - rise * rise);
        // Of the ball's surface over the point; far over it is that of another part.
        const double height = std::sqrt(std::max(0.0, left)) - rise;
        if (left > 0 && height >= -kHeld * dip(place.ball.radius) && height <= dip(inset_)) {
          return true;
        }
        const double out = from.norm() - ball.radius;
        if (place.ball.radius < kSmaller * fitting_[k] && out <= kEdgeRounding * ball.radius) {
          return true;
        }
      }
    }
    return false;
  }

  void take(SolidBall ball) {
    fitting_.push_back(ball.radius);
    ball.radius += dip(ball.radius) / 2;
    cells_[key_of(ball.center, side())].push_back(taken_.size());
    taken_.push_back(ball);
  }

  /// Of the cells of taken balls: what can hold a point is in the cells next to it.
  double side() const { return (1 + kEdgeRounding) * 1.25 * inset_; }

  const geometry::TriangleMesh& solid_;
  geometry::MeshQuery query_;
  double tolerance_, inset_;
  std::vector<Place> places_;
  std::vector<SolidBall> taken_;
  std::vector<double> fitting_;  // m, their radii before they grew
  std::map<CellKey, std::vector<std::size_t>> cells_;
};

}  // namespace

std::vector<SolidBall> balls_within(const geometry::TriangleMesh& solid, double tolerance) {
  return SolidCover(solid, tolerance).balls();
}

}  // namespace prehend::grasp
