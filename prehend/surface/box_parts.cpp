#include "prehend/surface/box_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <utility>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/surface/extremes.h"
#include "prehend/surface/hull_faces.h"
#include "prehend/surface/solid_hull.h"

namespace prehend::surface {
namespace {

constexpr std::size_t kHullDirections = 64;  // in which extremes are looked for
// Weight of the halves' difference in size. The first cuts of a ring leave what the hulls fill as
// it is; without it, slices would be cut off the rim.
constexpr double kBalance = 0.3;

/// Directions spread over the sphere by the golden angle, and the six axes.
const std::vector<Eigen::Vector3f>& directions() {
  static const std::vector<Eigen::Vector3f> all = [] {
    std::vector<Eigen::Vector3f> result;
    for (int axis = 0; axis < 3; ++axis) {
      result.push_back(Eigen::Vector3f::Unit(axis));
      result.push_back(-Eigen::Vector3f::Unit(axis));
    }
    const auto spread = spread_directions<float>(kHullDirections);
    result.insert(result.end(), spread.begin(), spread.end());
    return result;
  }();
  return all;
}

/// A set of filled voxels by its extremes.
struct Hull {
  std::vector<Eigen::Vector3f> points;  // extreme voxel centres
  HullFaces faces{{}};                  // empty when there are no points
  float margin = 0;                     // voxels, that the faces are to be moved outward
  Eigen::Vector3i low;                  // bounds of the points
  Eigen::Vector3i high;
};

Hull box_hull(const std::vector<Eigen::Vector3f>& candidates) {
  constexpr double kMargin = 0.05;  // voxels
  constexpr double kSolid = 1e-8;   // Scatter::solidity of what is not flat
  Hull hull;
  if (candidates.empty()) return hull;
  std::vector<Eigen::Vector3d> corners;
  hull.low = hull.high = candidates.front().cast<int>();
  for (const std::size_t i : extremes_of(candidates, directions())) {
    const Eigen::Vector3f& p = candidates[i];
    hull.points.push_back(p);
    corners.push_back(p.cast<double>());
    hull.low = hull.low.cwiseMin(p.cast<int>());
    hull.high = hull.high.cwiseMax(p.cast<int>());
  }
  if (scatter_of(corners).solidity > kSolid) {
    hull.margin = static_cast<float>(kMargin);
    hull.faces = HullFaces(geometry::convex_hull(corners));
    return hull;
  }
  // A small octahedron about each keeps hulls of flat sets from being flat.
  std::vector<Eigen::Vector3d> widened;
  for (const Eigen::Vector3d& p : corners) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double step : {-kMargin, kMargin}) {
        widened.push_back(p + step * Eigen::Vector3d::Unit(axis));
      }
    }
  }
  hull.faces = HullFaces(geometry::convex_hull(widened));
  return hull;
}

/// What is to be cut: one box with the hull of its filled voxels.
struct Piece {
  std::vector<VoxelBox> boxes;
  Hull hull;
  float concavity = 0;
  Eigen::Vector3i deepest = Eigen::Vector3i::Zero();  // the voxel that is so far from the solid
};

class Decomposition {
 public:
  Decomposition(const VoxelSolid& solid, float concavity, int max_parts)
      : solid_(solid), concavity_(concavity), max_parts_(max_parts) {
    // Sums of the distances along each row, to be had for a part of a row at once.
    sums_.resize(static_cast<std::size_t>(solid.size.x() + 1) * solid.size.y() * solid.size.z());
    for (std::size_t row = 0; row < sums_.size() / (solid.size.x() + 1); ++row) {
      double* sum = &sums_[row * (solid.size.x() + 1)];
      const float* distance = &solid.distance[row * solid.size.x()];
      sum[0] = 0;
      for (int x = 0; x < solid.size.x(); ++x) sum[x + 1] = sum[x] + distance[x];
    }
  }

  std::vector<BoxPart> run() {
    std::vector<Piece> pieces;
    pieces.push_back(piece({Eigen::Vector3i::Zero(), solid_.size - Eigen::Vector3i::Ones()}));
    while (static_cast<int>(pieces.size()) < max_parts_) {
      std::size_t worst = 0;
      for (std::size_t i = 1; i < pieces.size(); ++i) {
        if (pieces[i].concavity > pieces[worst].concavity) worst = i;
      }
      if (pieces[worst].concavity <= concavity_) break;
      auto halves = cut(pieces[worst]);
      if (!halves) break;
      pieces[worst] = std::move(halves->first);
      pieces.push_back(std::move(halves->second));
    }
    join(pieces);
    std::vector<BoxPart> parts;
    for (const Piece& p : pieces) parts.push_back({p.boxes, p.concavity});
    return parts;
  }

 private:
  /// Calls f(index of the row, first voxel, last voxel) for each row of voxels in the hull.
  template <typename Function>
  void for_rows(const Hull& hull, Function f) const {
    if (hull.faces.empty()) return;
    const int begin = hull.low.y();
    const auto count = static_cast<std::size_t>(hull.high.y() - begin + 1);
    std::vector<float> low(count), high(count);
    for (int z = hull.low.z(); z <= hull.high.z(); ++z) {
      hull.faces.rows(static_cast<float>(begin), static_cast<float>(z), hull.margin, low, high);
      for (std::size_t i = 0; i < count; ++i) {
        if (!(low[i] <= high[i])) continue;
        const int first = std::max(0, static_cast<int>(std::ceil(low[i])));
        const int last = std::min(solid_.size.x() - 1, static_cast<int>(std::floor(high[i])));
        if (first <= last) f(begin + static_cast<int>(i), z, first, last);
      }
    }
  }

  /// Sum of the distances from the solid over the voxels in the hull.
  double cost(const Hull& hull) const {
    double sum = 0;
    for_rows(hull, [&](int y, int z, int first, int last) {
      const double* row =
          &sums_[(static_cast<std::size_t>(z) * solid_.size.y() + y) * (solid_.size.x() + 1)];
      sum += row[last + 1] - row[first];
    });
    return sum;
  }

  void measure(Piece& piece) const {
    piece.concavity = 0;
    for_rows(piece.hull, [&](int y, int z, int first, int last) {
      const float* row = &solid_.distance[solid_.index(0, y, z)];
      for (int x = first; x <= last; ++x) {
        if (row[x] <= piece.concavity) continue;
        piece.concavity = row[x];
        piece.deepest = {x, y, z};
      }
    });
  }

  /// First and last filled voxel of each row of the box.
  std::vector<Eigen::Vector3f> row_ends(const VoxelBox& box) const {
    std::vector<Eigen::Vector3f> ends;
    for (int z = box.low.z(); z <= box.high.z(); ++z) {
      for (int y = box.low.y(); y <= box.high.y(); ++y) {
        const std::size_t row = solid_.index(0, y, z);
        int first = box.low.x();
        while (first <= box.high.x() && !solid_.filled[row + first]) ++first;
        if (first > box.high.x()) continue;
        int last = box.high.x();
        while (!solid_.filled[row + last]) --last;
        ends.emplace_back(first, y, z);
        if (last > first) ends.emplace_back(last, y, z);
      }
    }
    return ends;
  }

  Piece piece(const VoxelBox& box) const {
    Piece result;
    result.hull = box_hull(row_ends(box));
    result.boxes = {box};
    measure(result);
    return result;
  }

  Eigen::Vector3i nearest_filled(const Eigen::Vector3i& voxel) const {
    const int reach =
        static_cast<int>(std::ceil(solid_.distance[solid_.index(voxel.x(), voxel.y(), voxel.z())]));
    const Eigen::Vector3i low = (voxel.array() - reach).max(0).matrix();
    const Eigen::Vector3i high = (voxel.array() + reach).min(solid_.size.array() - 1).matrix();
    Eigen::Vector3i best = voxel;
    int least = -1;
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          if (!solid_.filled[solid_.index(x, y, z)]) continue;
          const int distance = (Eigen::Vector3i(x, y, z) - voxel).squaredNorm();
          if (least >= 0 && distance >= least) continue;
          least = distance;
          best = {x, y, z};
        }
      }
    }
    return best;
  }

  /// The best cut of the piece's box, none when no plane leaves filled voxels on both sides.
  std::optional<std::pair<Piece, Piece>> cut(const Piece& whole) const {
    const VoxelBox& box = whole.boxes.front();
    const Eigen::Vector3i nearest = nearest_filled(whole.deepest);
    const double of_whole = cost(whole.hull);
    std::optional<std::pair<VoxelBox, VoxelBox>> best;
    double least = 0;
    for (int axis = 0; axis < 3; ++axis) {
      // The last layer of the lower half.
      const std::set<int> layers{whole.deepest[axis], whole.deepest[axis] - 1, nearest[axis],
                                 nearest[axis] - 1,
                                 (whole.hull.low[axis] + whole.hull.high[axis]) / 2};
      for (const int layer : layers) {
        if (layer < whole.hull.low[axis] || layer >= whole.hull.high[axis]) continue;
        VoxelBox lower = box;
        VoxelBox upper = box;
        lower.high[axis] = layer;
        upper.low[axis] = layer + 1;
        const std::vector<Eigen::Vector3f> of_lower = row_ends(lower);
        const std::vector<Eigen::Vector3f> of_upper = row_ends(upper);
        const double imbalance =
            std::abs(static_cast<double>(of_lower.size()) - static_cast<double>(of_upper.size())) /
            static_cast<double>(of_lower.size() + of_upper.size());
        double sum = kBalance * imbalance * of_whole;
        for (const auto* half : {&of_lower, &of_upper}) {
          if (!best || sum < least) sum += cost(box_hull(*half));
        }
        if (best && sum >= least) continue;
        best = {lower, upper};
        least = sum;
      }
    }
    if (!best) return std::nullopt;
    return std::pair(piece(best->first), piece(best->second));
  }

  static bool touch(const Piece& a, const Piece& b) {
    return ((a.hull.low.array() - 2 <= b.hull.high.array()) &&
            (b.hull.low.array() - 2 <= a.hull.high.array()))
        .all();
  }

  Piece joined(const Piece& a, const Piece& b) const {
    std::vector<Eigen::Vector3f> points = a.hull.points;
    points.insert(points.end(), b.hull.points.begin(), b.hull.points.end());
    Piece result;
    result.hull = box_hull(points);
    result.boxes = a.boxes;
    result.boxes.insert(result.boxes.end(), b.boxes.begin(), b.boxes.end());
    measure(result);
    return result;
  }

  /// Joins the pair with the least concavity, again and again.
  void join(std::vector<Piece>& pieces) const {
    struct Pair {
      std::size_t a;
      std::size_t b;
      Piece piece;
    };
    std::vector<Pair> pairs;
    const auto consider = [&](std::size_t a, std::size_t b) {
      if (!touch(pieces[a], pieces[b])) return;
      Piece both = joined(pieces[a], pieces[b]);
      if (both.concavity <= concavity_) pairs.push_back({a, b, std::move(both)});
    };
    std::vector<bool> gone(pieces.size(), false);
    for (std::size_t a = 0; a < pieces.size(); ++a) {
      for (std::size_t b = a + 1; b < pieces.size(); ++b) consider(a, b);
    }
    while (!pairs.empty()) {
      const auto best = std::min_element(
          pairs.begin(), pairs.end(),
          [](const Pair& p, const Pair& q) { return p.piece.concavity < q.piece.concavity; });
      const std::size_t a = best->a;
      const std::size_t b = best->b;
      pieces[a] = std::move(best->piece);
      gone[b] = true;
      std::erase_if(pairs,
                    [&](const Pair& p) { return p.a == a || p.b == a || p.a == b || p.b == b; });
      for (std::size_t other = 0; other < pieces.size(); ++other) {
        if (other != a && !gone[other]) consider(std::min(a, other), std::max(a, other));
      }
    }
    std::vector<Piece> left;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (!gone[i]) left.push_back(std::move(pieces[i]));
    }
    pieces = std::move(left);
  }

  const VoxelSolid& solid_;
  float concavity_;
  int max_parts_;
  std::vector<double> sums_;
};

}  // namespace

std::vector<BoxPart> convex_parts(const VoxelSolid& solid, float concavity, int max_parts) {
  return Decomposition(solid, concavity, max_parts).run();
}

}  // namespace prehend::surface
