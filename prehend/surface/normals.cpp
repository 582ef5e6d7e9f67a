#include "prehend/surface/normals.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>
#include <flann/flann.hpp>

#include "prehend/geometry/errors.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using Points = std::vector<Eigen::Vector3f>;

constexpr double kUnitsAcross = 6.9e10;  // of the fixed point of sums, about 2^36
constexpr double kLeastExtent = 1e-30;   // m: a voxel may hold all points, and they coincide

struct Neighbors {
  int count = 0;                 // per point, the point itself first
  std::vector<int> indices;      // n x count
  std::vector<float> distances;  // n x count, squared [m^2]
};

Neighbors nearest_neighbors(const Points& points, int count) {
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  Neighbors result;
  result.count = count;
  result.indices.resize(points.size() * count);
  result.distances.resize(points.size() * count);
  const flann::Matrix<float> data(const_cast<float*>(points.front().data()), points.size(), 3);
  flann::Matrix<int> indices(result.indices.data(), points.size(), count);
  flann::Matrix<float> distances(result.distances.data(), points.size(), count);
  flann::KDTreeSingleIndex<flann::L2_Simple<float>> index(data, flann::KDTreeSingleIndexParams(15));
  index.buildIndex();
  flann::SearchParams search(flann::FLANN_CHECKS_UNLIMITED, 0, true);
  search.cores = 1;
  index.knnSearch(data, indices, distances, count, search);
  return result;
}

void check_finite(const Points& points) {
  if (!std::all_of(points.begin(), points.end(), geometry::is_finite)) {
    throw InputError("the cloud has points that are not finite", "remove invalid points");
  }
}

/// True for the points whose mean distance to their nearest `options.neighbors` is not far over the
/// average. @pre nearest.count > options.neighbors.
std::vector<bool> inliers(const Neighbors& nearest, const OutlierOptions& options) {
  const std::size_t n = nearest.indices.size() / nearest.count;
  std::vector<double> mean_distance(n, 0);
  double sum = 0;
  double sum_of_squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (int j = 1; j <= options.neighbors; ++j) {
      mean_distance[i] += std::sqrt(nearest.distances[i * nearest.count + j]);
    }
    mean_distance[i] /= options.neighbors;
    sum += mean_distance[i];
    sum_of_squares += mean_distance[i] * mean_distance[i];
  }
  const double mean = sum / static_cast<double>(n);
  const double variance = sum_of_squares / static_cast<double>(n) - mean * mean;
  const double limit = mean + options.deviations * std::sqrt(std::max(0.0, variance));
  std::vector<bool> kept(n);
  for (std::size_t i = 0; i < n; ++i) kept[i] = mean_distance[i] <= limit;
  return kept;
}

/// The normal of the plane that fits point `i` and its nearest `count` - 1 neighbours best, of
/// those that are `used`.
Eigen::Vector3d plane_normal(const Points& points, const Neighbors& nearest, std::size_t i,
                             int count, const std::vector<bool>& used) {
  const int* indices = &nearest.indices[i * nearest.count];
  const Eigen::Vector3f& origin = points[i];
  // About the point itself, in single precision: neighbours are near, and their differences exact.
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  int n = 0;
  const float scale = nearest.distances[(i + 1) * nearest.count - 1] > 0
                          ? 1 / std::sqrt(nearest.distances[(i + 1) * nearest.count - 1])
                          : 1;
  for (int j = 0; j < count; ++j) {
    if (!used[indices[j]]) continue;
    const Eigen::Vector3f r = scale * (points[indices[j]] - origin);
    sum += r;
    xx += r.x() * r.x();
    xy += r.x() * r.y();
    xz += r.x() * r.z();
    yy += r.y() * r.y();
    yz += r.y() * r.z();
    zz += r.z() * r.z();
    ++n;
  }
  const Eigen::Vector3d mean = sum.cast<double>() / n;
  Eigen::Matrix3d covariance;
  covariance << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  covariance = covariance / n - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  return solver.eigenvectors().col(0);
}

Eigen::Vector3f towards(const Eigen::Vector3d& normal, const Eigen::Vector3f& point,
                        const Eigen::Vector3d& viewpoint) {
  return (normal.dot(viewpoint - point.cast<double>()) < 0 ? Eigen::Vector3d(-normal) : normal)
      .cast<float>();
}

void check(const NormalOptions& options) {
  if (options.neighbors < 3) throw std::invalid_argument("NormalOptions.neighbors must be >= 3");
}

void check(const OutlierOptions& options) {
  if (options.neighbors < 1 || !(options.deviations > 0)) {
    throw std::invalid_argument("OutlierOptions: neighbors must be >= 1 and deviations > 0");
  }
}

void check_enough(std::size_t points, int neighbors) {
  if (points > static_cast<std::size_t>(neighbors)) return;
  throw InputError("the cloud has " + std::to_string(points) + " points, too few for " +
                       std::to_string(neighbors) + " neighbours each",
                   "give more points or fewer neighbours");
}

/// A voxel's sum, in fixed point: exact, so that the order of the points does not matter.
struct VoxelSum {
  std::array<int, 3> cell;  // z, y, x
  std::array<std::int64_t, 3> sum{};
  int count = 0;
};

/// The voxels that were added to, found by hashing.
class VoxelSums {
 public:
  explicit VoxelSums(std::size_t most) : slots_(std::bit_ceil(2 * most + 1), -1) {}

  VoxelSum& at(const std::array<int, 3>& cell) {
    std::uint64_t hash = 0;
    for (const int index : cell) {
      hash = (hash ^ static_cast<std::uint32_t>(index)) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
    for (std::size_t slot = hash & (slots_.size() - 1);; slot = (slot + 1) & (slots_.size() - 1)) {
      if (slots_[slot] < 0) {
        slots_[slot] = static_cast<int>(voxels_.size());
        return voxels_.emplace_back(VoxelSum{cell});
      }
      VoxelSum& voxel = voxels_[static_cast<std::size_t>(slots_[slot])];
      if (voxel.cell == cell) return voxel;
    }
  }
  std::vector<VoxelSum> sorted() && {
    std::sort(voxels_.begin(), voxels_.end(),
              [](const VoxelSum& a, const VoxelSum& b) { return a.cell < b.cell; });
    return std::move(voxels_);
  }

 private:
  std::vector<int> slots_;
  std::vector<VoxelSum> voxels_;
};

/// Means of the points in each cubic voxel, in the order of the voxels. The order of the points
/// does not matter.
Points voxel_means(const Points& points, double side) {
  if (points.empty()) return {};
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) box.extend(p);
  // Cells are counted from the origin, so that two clouds have the same ones.
  const Eigen::Array3d first = (box.min().cast<double>().array() / side).floor();
  const Eigen::Array3d count = (box.max().cast<double>().array() / side).floor() - first + 1;
  if (!(count.maxCoeff() < 1e9)) {
    throw std::invalid_argument("OrientedCloudOptions.spacing is far too small for the cloud");
  }
  // 36 bits for the extent leave room for 2^27 points in a voxel.
  const Eigen::Array3d least = box.min().cast<double>().array();
  const double unit = std::max<double>(box.sizes().maxCoeff(), kLeastExtent) / kUnitsAcross;
  VoxelSums sums(points.size());
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Array3d p = point.cast<double>().array();
    const Eigen::Array3d cell = (p / side).floor() - first;
    VoxelSum& voxel = sums.at(
        {static_cast<int>(cell.z()), static_cast<int>(cell.y()), static_cast<int>(cell.x())});
    const Eigen::Array3d units = (p - least) / unit;
    for (int axis = 0; axis < 3; ++axis) voxel.sum[axis] += std::llrint(units[axis]);
    ++voxel.count;
  }
  Points means;
  for (const VoxelSum& voxel : std::move(sums).sorted()) {
    const Eigen::Array3d sum(static_cast<double>(voxel.sum[0]), static_cast<double>(voxel.sum[1]),
                             static_cast<double>(voxel.sum[2]));
    means.push_back((least + sum / voxel.count * unit).matrix().cast<float>());
  }
  return means;
}

}  // namespace

std::vector<int> without_outliers(const Points& points, const OutlierOptions& options) {
  check(options);
  check_finite(points);
  std::vector<bool> kept(points.size(), true);
  if (points.size() > static_cast<std::size_t>(options.neighbors)) {
    kept = inliers(nearest_neighbors(points, options.neighbors + 1), options);
  }
  std::vector<int> indices;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (kept[i]) indices.push_back(static_cast<int>(i));
  }
  return indices;
}

std::vector<Eigen::Vector3f> estimate_normals(const Points& points,
                                              const std::vector<Eigen::Vector3d>& viewpoints,
                                              const NormalOptions& options) {
  check(options);
  if (viewpoints.size() != points.size()) {
    throw std::invalid_argument("estimate_normals: one viewpoint per point is needed");
  }
  check_finite(points);
  check_enough(points.size(), options.neighbors);
  const int count = options.neighbors + 1;
  const Neighbors nearest = nearest_neighbors(points, count);
  const std::vector<bool> all(points.size(), true);
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    normals.push_back(
        towards(plane_normal(points, nearest, i, count, all), points[i], viewpoints[i]));
  }
  return normals;
}

namespace {

/// Points of one or several origins, and what their normals look at.
struct ThinnedPoints {
  Points points;
  std::vector<Eigen::Vector3d> viewpoints;
  std::vector<bool> seen;
};

/// Appends the inliers of `thinned` with their normals. One search serves the filter and the
/// planes.
void append_oriented(const ThinnedPoints& thinned, const OrientedCloudOptions& options,
                     geometry::PointCloud& cloud, std::vector<bool>& seen) {
  const Points& points = thinned.points;
  const int count = options.normals.neighbors + 1;
  const int searched =
      std::max(count, std::min(options.outliers.neighbors + 1, static_cast<int>(points.size())));
  const Neighbors nearest = nearest_neighbors(points, searched);
  std::vector<bool> kept(points.size(), true);
  if (searched > options.outliers.neighbors) kept = inliers(nearest, options.outliers);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!kept[i]) continue;
    const Eigen::Vector3d normal = plane_normal(points, nearest, i, count, kept);
    cloud.points.push_back(points[i]);
    cloud.normals.push_back(towards(normal, points[i], thinned.viewpoints[i]));
    seen.push_back(thinned.seen[i]);
  }
}

}  // namespace

geometry::PointCloud oriented_cloud(const shape::CompletedShape& shape,
                                    const OrientedCloudOptions& options, std::vector<bool>* seen) {
  if (!(options.spacing >= 0) || !std::isfinite(options.spacing)) {
    throw std::invalid_argument("OrientedCloudOptions.spacing must be >= 0");
  }
  const Points& points = shape.cloud_W.points;
  if (points.empty() || shape.origin.size() != points.size()) {
    throw InputError("the completed shape has no points, or not one origin per point",
                     "complete the shape again");
  }
  check(options.outliers);
  check(options.normals);
  check_finite(points);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) box.extend(p);
  const double spacing = options.spacing > 0 ? options.spacing : box.sizes().maxCoeff() / 90.0;
  if (!(spacing > 0)) {
    throw InputError("all points of the completed shape coincide", "segment the object again");
  }

  geometry::PointCloud cloud;
  std::vector<bool> is_seen;
  ThinnedPoints thinned;
  for (const auto origin :
       {shape::PointOrigin::kSeen, shape::PointOrigin::kMirrored,
        shape::PointOrigin::kMirroredSecond, shape::PointOrigin::kMirroredBoth}) {
    Points of_origin;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (shape.origin[i] == origin) of_origin.push_back(points[i]);
    }
    of_origin = voxel_means(std::move(of_origin), spacing);
    thinned.points.insert(thinned.points.end(), of_origin.begin(), of_origin.end());
    thinned.viewpoints.resize(thinned.points.size(), shape.viewpoint_of(origin));
    thinned.seen.resize(thinned.points.size(), origin == shape::PointOrigin::kSeen);
    const bool enough = thinned.points.size() > static_cast<std::size_t>(options.normals.neighbors);
    if (options.separate_origins && enough) {
      append_oriented(thinned, options, cloud, is_seen);
      thinned = {};
    }
  }
  if (!options.separate_origins) {
    check_enough(thinned.points.size(), options.normals.neighbors);
    append_oriented(thinned, options, cloud, is_seen);
  }
  if (seen) *seen = std::move(is_seen);
  return cloud;
}

}  // namespace prehend::surface
