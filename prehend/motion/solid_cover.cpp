#include "prehend/motion/solid_cover.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <stdexcept>
#include <string>
#include <utility>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;

constexpr std::size_t kMostCells = 20000;
constexpr std::size_t kEnoughCells = 4000;
constexpr std::size_t kMostSeeds = 500;
constexpr int kDoublings = 5, kHalvings = 6, kTurns = 3;
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

/// A box that holds what of a solid is in a part of space.
struct Cell {
  Vector3d center, half;  // m
  double distance = 0;    // m, of the centre, signed
};

/// Radius of a ball about `center` that holds all of the cell.
double radius_for(const Cell& cell, const Vector3d& center) {
  return ((center - cell.center).cwiseAbs() + cell.half).norm() + kRoundingUp;
}

/// Cells that together hold a solid, each so small that a ball about its centre reaches at most
/// `overshoot` beyond the solid.
class SolidCells {
 public:
  SolidCells(const geometry::TriangleMesh& solid, const geometry::MeshQuery& query,
             double overshoot, std::size_t most)
      : query_(query), overshoot_(overshoot), most_(most) {
    std::vector<Polygon> surface;
    for (const Eigen::Vector3i& t : solid.triangles) {
      surface.push_back({solid.vertices[t.x()], solid.vertices[t.y()], solid.vertices[t.z()]});
    }
    split(surface, query_.box());
  }

  bool are_too_many() const { return cells_.size() > most_; }
  std::vector<Cell> cells() && { return std::move(cells_); }

 private:
  /// Takes what of the solid is in `box`, where its surface is `surface`.
  void split(const std::vector<Polygon>& surface, const Eigen::AlignedBox3d& box) {
    if (are_too_many()) return;
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
    Cell cell{filled.center(), filled.sizes() / 2, 0};
    const double radius = radius_for(cell, cell.center);
    cell.distance = query_.signed_distance(cell.center);
    // A ball about the centre that is all inside takes its radius from what is outside.
    if (radius + cell.distance <= overshoot_ || radius <= overshoot_ / 2) {
      cells_.push_back(cell);
      return;
    }
    int axis = 0;
    filled.sizes().maxCoeff(&axis);
    const double middle = cell.center[axis];
    std::vector<Polygon> low, high;
    for (const Polygon& polygon : surface) {
      auto [below, above] = halves(polygon, axis, middle);
      if (!below.empty()) low.push_back(std::move(below));
      if (!above.empty()) high.push_back(std::move(above));
    }
    Eigen::AlignedBox3d half = filled;
    half.max()[axis] = middle;
    split(low, half);
    half = filled;
    half.min()[axis] = middle;
    split(high, half);
  }

  const geometry::MeshQuery& query_;
  double overshoot_;
  std::size_t most_;
  std::vector<Cell> cells_;
};

std::vector<Cell> cells_of(const geometry::TriangleMesh& solid, const geometry::MeshQuery& query,
                           double overshoot) {
  // The smaller the cells, the fewer balls hold all of them.
  for (const double share : {0.3, 0.6}) {
    SolidCells cells(solid, query, share * overshoot, kEnoughCells);
    if (!cells.are_too_many()) return std::move(cells).cells();
  }
  SolidCells cells(solid, query, overshoot, kMostCells);
  if (cells.are_too_many()) {
    throw geometry::InputError("A solid of " + std::to_string(query.box().sizes().maxCoeff()) +
                                   " m needs more than 20000 balls to reach at most " +
                                   std::to_string(overshoot) + " m beyond it",
                               "Take a coarser resolution");
  }
  return std::move(cells).cells();
}

/// Balls as large as they may be: about cells' centres, and about points further in, up to where
/// another part of the surface is as near (the medial axis).
class Candidates {
 public:
  Candidates(const geometry::MeshQuery& query, const std::vector<Cell>& cells, double overshoot)
      : query_(query), overshoot_(overshoot) {
    for (const Cell& cell : cells) {
      balls_.push_back(
          {cell.center, std::max(overshoot - cell.distance, radius_for(cell, cell.center))});
    }
    const std::size_t stride = cells.size() / kMostSeeds + 1;
    for (std::size_t i = 0; i < cells.size(); i += stride) go_in(cells[i]);
  }
  std::vector<Ball> balls() && { return std::move(balls_); }

 private:
  /// Adds the ball at `depth` under the surface's point; whether that is the nearest of it.
  bool add_under(const Vector3d& surface, const Vector3d& inward, double depth) {
    const Vector3d center = surface + depth * inward;
    // Where it is so far from all of the surface is looked for no farther than the point above it.
    const auto nearest = query_.nearest(center, 1.001 * depth);
    if (!nearest || nearest->distance <= 0.99 * depth || !query_.contains(center)) return false;
    balls_.push_back({center, overshoot_ + nearest->distance});
    return true;
  }

  /// Away from the nearest part of the surface until another is as near, then away from that.
  void go_in(const Cell& cell) {
    Vector3d center = cell.center;
    bool is_inside = cell.distance < 0;
    for (int turn = 0; turn < kTurns; ++turn) {
      const std::optional<geometry::NearestPoint> nearest = query_.nearest(center);
      if (!nearest || !(nearest->distance > 1e-6)) return;
      const Vector3d inward = (is_inside ? 1.0 : -1.0) * (center - nearest->point).normalized();
      double reached = is_inside && turn > 0 ? nearest->distance : 0;
      double depth = std::max(overshoot_ / 2, 1.5 * reached);
      for (int k = 0; k < kDoublings && add_under(nearest->point, inward, depth); ++k) {
        reached = depth;
        depth *= 2;
      }
      double beyond = depth;
      for (int k = 0; k < kHalvings; ++k) {
        const double between = (reached + beyond) / 2;
        (add_under(nearest->point, inward, between) ? reached : beyond) = between;
      }
      if (!(reached > 0)) return;
      center = nearest->point + reached * inward;
      is_inside = true;
    }
  }

  const geometry::MeshQuery& query_;
  double overshoot_;
  std::vector<Ball> balls_;
};

/// Takes the ball that holds most of the cells that none holds yet, again and again (V. Chvatal, "A
/// greedy heuristic for the set-covering problem", 1979), then makes each as small as its cells
/// allow.
std::vector<Ball> fewest(const std::vector<Cell>& cells, const std::vector<Ball>& candidates) {
  std::vector<std::vector<int>> held(candidates.size());
  for (std::size_t b = 0; b < candidates.size(); ++b) {
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (radius_for(cells[c], candidates[b].center) <= candidates[b].radius) {
        held[b].push_back(static_cast<int>(c));
      }
    }
  }
  // What a ball adds never grows: it is counted anew only where it comes first.
  std::vector<int> by(cells.size(), -1);
  using Entry = std::pair<std::size_t, int>;  // cells, minus the ball: the first of as many
  std::priority_queue<Entry> queue;
  for (std::size_t b = 0; b < candidates.size(); ++b) {
    queue.push({held[b].size(), -static_cast<int>(b)});
  }
  std::vector<int> chosen;
  while (!queue.empty() && queue.top().first > 0) {
    const auto [count, minus] = queue.top();
    queue.pop();
    std::vector<int>& its = held[static_cast<std::size_t>(-minus)];
    std::erase_if(its, [&](int c) { return by[static_cast<std::size_t>(c)] >= 0; });
    if (its.size() < count) {
      queue.push({its.size(), minus});
      continue;
    }
    for (const int c : its) by[static_cast<std::size_t>(c)] = static_cast<int>(chosen.size());
    chosen.push_back(-minus);
  }
  std::vector<Ball> balls;
  for (const int b : chosen) balls.push_back({candidates[static_cast<std::size_t>(b)].center, 0});
  for (const Cell& cell : cells) {
    // Of all that may hold it, the one that has to grow least.
    Ball* least = nullptr;
    double growth = 0;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const double radius = radius_for(cell, balls[i].center);
      if (radius > candidates[static_cast<std::size_t>(chosen[i])].radius) continue;
      const double more = std::max(0.0, radius - balls[i].radius);
      if (!least || more < growth) {
        least = &balls[i];
        growth = more;
      }
    }
    least->radius += growth;
  }
  std::erase_if(balls, [](const Ball& ball) { return !(ball.radius > 0); });
  return balls;
}

}  // namespace

std::vector<Ball> cover_solid(const geometry::TriangleMesh& solid, double overshoot) {
  if (!(overshoot > 0) || !std::isfinite(overshoot)) {
    throw std::invalid_argument("cover_solid: the overshoot must be positive");
  }
  const geometry::MeshQuery query(solid);
  const std::vector<Cell> cells = cells_of(solid, query, overshoot);
  return fewest(cells, Candidates(query, cells, overshoot).balls());
}

}  // namespace prehend::motion
