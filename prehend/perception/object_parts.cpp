#include "prehend/perception/object_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include <Eigen/Dense>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/symmetric_solve.h"
#include "prehend/perception/cloud_partition.h"

namespace prehend::perception {
namespace {

constexpr std::size_t kMinPartPoints = 12;  // fewer say nothing about a shape
constexpr double kHollowSagitta = 0.12;     // depth of a hollow footprint over its half width
constexpr double kOverlap = 0.6;            // of the lateral widths of inner and outer wall
constexpr double kRimDifference = 0.025;    // m, between the heights of the two walls
constexpr double kWallGap = 0.6;            // of the width, between the walls' nearest points

struct Part {
  double lowest = 0;   // m over the table
  double highest = 0;  // m, 98 % quantile
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
};

double quantile(std::vector<double>& values, double q) {
  const auto k = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

class PartJoiner {
 public:
  PartJoiner(const std::vector<Eigen::Vector3f>& points,
             const std::vector<std::vector<int>>& clusters, const geometry::Plane& table)
      : points_(points), clusters_(clusters), table_(table) {
    for (const std::vector<int>& cluster : clusters) {
      Part part;
      std::vector<double> heights;
      for (const int i : cluster) {
        const Eigen::Vector3d p = points[i].cast<double>();
        part.center += p / static_cast<double>(cluster.size());
        heights.push_back(table.signed_distance(p));
      }
      part.lowest = quantile(heights, 0.02);
      part.highest = quantile(heights, 0.98);
      parts_.push_back(part);
    }
  }

  const Part& part(std::size_t k) const { return parts_[k]; }

  double distance(std::size_t a, std::size_t b) const {
    float least = std::numeric_limits<float>::infinity();
    for (const int i : clusters_[a]) {
      for (const int j : clusters_[b]) {
        least = std::min(least, (points_[i] - points_[j]).squaredNorm());
      }
    }
    return std::sqrt(static_cast<double>(least));
  }

  // The cluster that part k belongs to, as it floats or stands within that one's outline.
  std::optional<std::size_t> carrier_of(std::size_t k, bool floats, double contact_height,
                                        double join_gap) const {
    std::optional<std::size_t> carrier;
    double nearest = join_gap;
    for (std::size_t other = 0; other < clusters_.size(); ++other) {
      if (other == k || parts_[other].lowest > contact_height) continue;
      if (clusters_[other].size() < 2 * clusters_[k].size()) continue;
      const double gap = distance(k, other);
      if (gap >= nearest || (!floats && !is_within(k, other))) continue;
      nearest = gap;
      carrier = other;
    }
    return carrier;
  }

  // The nearest cluster that stands on the table, cannot carry part k and looks like it.
  std::optional<std::size_t> foot_of(
      std::size_t k, const PartOptions& options,
      const std::function<bool(std::size_t, std::size_t)>& look_alike) const {
    std::optional<std::size_t> foot;
    double nearest = options.join_gap;
    for (std::size_t other = 0; other < clusters_.size(); ++other) {
      if (other == k || parts_[other].lowest > options.contact_height) continue;
      const std::size_t size = clusters_[other].size();
      if (size < kMinPartPoints || size >= clusters_[k].size()) continue;
      const double gap = distance(k, other);
      if (gap >= nearest || carries(other, k) || !look_alike(k, other)) continue;
      nearest = gap;
      foot = other;
    }
    return foot;
  }

  // The near wall of the vessel whose far inside wall is part k.
  std::optional<std::size_t> near_wall_of(std::size_t k) const {
    if (clusters_[k].size() < kMinPartPoints) return std::nullopt;
    const View view = view_of(k);
    const Footprint far = footprint(k, view);
    const double half_width = 0.5 * (far.right - far.left);
    if (half_width <= 0 || far.curvature * half_width * half_width > -kHollowSagitta * half_width) {
      return std::nullopt;
    }
    std::optional<std::size_t> wall;
    double nearest = kWallGap * 2 * half_width;
    for (std::size_t other = 0; other < clusters_.size(); ++other) {
      if (other == k || clusters_[other].size() < kMinPartPoints) continue;
      if (std::abs(parts_[other].highest - parts_[k].highest) > kRimDifference) continue;
      const Footprint near = footprint(other, view);
      const double overlap = std::min(near.right, far.right) - std::max(near.left, far.left);
      const double widest = std::max(near.right - near.left, far.right - far.left);
      if (overlap < kOverlap * widest || near.middle >= far.middle) continue;
      const double gap = distance(k, other);
      if (gap >= nearest) continue;
      nearest = gap;
      wall = other;
    }
    return wall;
  }

 private:
  // Whether the middle of cluster k is over the other one.
  bool carries(std::size_t other, std::size_t k) const {
    const auto outline = outline_of(other);
    return outline && outline->contains(parts_[k].center, 0);
  }

  // Convex, along the table; none where a line is seen.
  std::optional<PlaneOutline> outline_of(std::size_t k) const {
    std::vector<Eigen::Vector3f> around;
    for (const int i : clusters_[k]) around.push_back(points_[i]);
    try {
      return PlaneOutline(table_, around);
    } catch (const geometry::InputError&) {
      return std::nullopt;
    }
  }

  // Whether all of cluster k stands within the convex outline of the other one, nearly.
  bool is_within(std::size_t k, std::size_t other) const {
    constexpr double kMargin = 0.008;  // m
    const auto outline = outline_of(other);
    return outline && std::all_of(clusters_[k].begin(), clusters_[k].end(), [&](int i) {
             return outline->contains(points_[i].cast<double>(), kMargin);
           });
  }

  struct View {
    Eigen::Vector3d along;    // horizontal, away from the camera
    Eigen::Vector3d lateral;  // horizontal
  };

  struct Footprint {
    double left = 0;  // m, 3 % and 97 % quantiles across
    double right = 0;
    double middle = 0;     // m, mean along the view
    double curvature = 0;  // 1/m, of along = a + b lateral + curvature lateral^2
  };

  View view_of(std::size_t k) const {
    Eigen::Vector3d along =
        table_.project(parts_[k].center) - table_.project(Eigen::Vector3d::Zero());
    // Straight from above every horizontal direction is as good.
    if (along.norm() < 1e-6) along = table_.normal.unitOrthogonal();
    along.normalize();
    return {along, table_.normal.cross(along)};
  }

  Footprint footprint(std::size_t k, const View& view) const {
    const std::vector<int>& cluster = clusters_[k];
    const Eigen::Vector3d& center = parts_[k].center;
    Eigen::MatrixX3d basis(static_cast<Eigen::Index>(cluster.size()), 3);
    Eigen::VectorXd along(basis.rows());
    std::vector<double> lateral;
    for (Eigen::Index r = 0; r < basis.rows(); ++r) {
      const Eigen::Vector3d p = points_[cluster[static_cast<std::size_t>(r)]].cast<double>();
      const double l = view.lateral.dot(p - center);
      lateral.push_back(view.lateral.dot(p));
      basis.row(r) << 1, l, l * l;
      along[r] = view.along.dot(p);
    }
    Footprint result;
    result.left = quantile(lateral, 0.03);
    result.right = quantile(lateral, 0.97);
    result.middle = along.mean();
    const Eigen::Matrix3d normal_matrix = basis.transpose() * basis;
    const Eigen::Vector3d moments = basis.transpose() * along;
    const Eigen::Vector3d solution = geometry::symmetric_solve<3>(normal_matrix, moments);
    if (solution.allFinite()) result.curvature = solution[2];
    return result;
  }

  const std::vector<Eigen::Vector3f>& points_;
  const std::vector<std::vector<int>>& clusters_;
  const geometry::Plane& table_;
  std::vector<Part> parts_;
};

}  // namespace

JoinedParts joined_parts(const std::vector<Eigen::Vector3f>& points,
                         const std::vector<std::vector<int>>& clusters,
                         const std::vector<char>& is_cut, const geometry::Plane& table_C,
                         const PartOptions& options,
                         const std::function<bool(std::size_t, std::size_t)>& look_alike) {
  const PartJoiner joiner(points, clusters, table_C);
  std::vector<std::size_t> target(clusters.size());
  std::iota(target.begin(), target.end(), 0);
  std::vector<char> hangs(clusters.size(), 0);
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    const bool floats = joiner.part(k).lowest > options.contact_height;
    std::optional<std::size_t> whole = joiner.near_wall_of(k);
    if (!whole) whole = joiner.carrier_of(k, floats, options.contact_height, options.join_gap);
    if (whole) {
      target[k] = *whole;
    } else if (is_cut[k] && joiner.part(k).lowest > options.drop_height) {
      hangs[k] = 1;
    }
  }
  // Parts of parts; a circle ends where it started.
  const auto root_of = [&](std::size_t k) {
    for (std::size_t steps = 0; target[k] != k && steps < clusters.size(); ++steps) k = target[k];
    return k;
  };
  for (std::size_t k = 0; look_alike && k < clusters.size(); ++k) {
    const bool floats = joiner.part(k).lowest > options.contact_height;
    if (!floats || is_cut[k] || target[k] != k) continue;
    const auto foot = joiner.foot_of(k, options, look_alike);
    if (foot && root_of(*foot) != k) target[k] = *foot;
  }
  std::vector<std::vector<int>> joined(clusters.size());
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    const std::size_t root = root_of(k);
    joined[root].insert(joined[root].end(), clusters[k].begin(), clusters[k].end());
  }
  JoinedParts result;
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    if (joined[k].empty()) continue;
    std::sort(joined[k].begin(), joined[k].end());
    (hangs[k] ? result.hanging : result.objects).push_back(std::move(joined[k]));
  }
  return result;
}

}  // namespace prehend::perception
