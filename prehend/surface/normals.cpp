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
  int count = 0;                 // per query; of a point of the cloud, the point itself first
  std::vector<int> indices;      // n x count
  std::vector<float> distances;  // n x count, squared [m^2]
};

/// Of each of `queries` the `count` nearest ones of `points`, nearest first.
Neighbors nearest_neighbors(const Points& points, const Points& queries, int count) {
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  Neighbors result;
  result.count = count;
  result.indices.resize(queries.size() * count);
  result.distances.resize(queries.size() * count);
  const auto matrix = [](const Points& p) {
    return flann::Matrix<float>(const_cast<float*>(p.front().data()), p.size(), 3);
  };
  const flann::Matrix<float> data = matrix(points);
  flann::Matrix<int> indices(result.indices.data(), queries.size(), count);
  flann::Matrix<float> distances(result.distances.data(), queries.size(), count);
  flann::KDTreeSingleIndex<flann::L2_Simple<float>> index(data, flann::KDTreeSingleIndexParams(15));
  index.buildIndex();
  flann::SearchParams search(flann::FLANN_CHECKS_UNLIMITED, 0, true);
  search.cores = 1;
  index.knnSearch(matrix(queries), indices, distances, count, search);
  return result;
}

Neighbors nearest_neighbors(const Points& points, int count) {
  return nearest_neighbors(points, points, count);
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

/// A quadratic surface over a plane.
struct LocalSurface {
  Eigen::Vector3f origin, x, y, normal;                        // of the plane, unit axes
  Eigen::Matrix<float, 6, 1> coefficients;                     // of 1, u, v, u^2, uv, v^2
  static Eigen::Matrix<float, 6, 1> terms(float u, float v) {  // u along x, v along y [m]
    return (Eigen::Matrix<float, 6, 1>() << 1, u, v, u * u, u * v, v * v).finished();
  }
  /// The height of the surface over `p`, along the normal [m].
  float over(const Eigen::Vector3f& p) const {
    const Eigen::Vector3f r = p - origin;
    return coefficients.dot(terms(r.dot(x), r.dot(y))) - r.dot(normal);
  }
};

/// The surface about point `i` that fits its nearest ones best; they count less with distance, and
/// where they are turned away.
LocalSurface fitted_about(std::size_t i, const Points& points, const Neighbors& nearest,
                          const std::vector<Eigen::Vector3f>& normals) {
  constexpr float kFalloff = 2;  // weight e^-2 at the farthest
  const Eigen::Vector3f& n = normals[i];
  LocalSurface surface{points[i], n.unitOrthogonal(), {}, n, {}};
  surface.y = n.cross(surface.x);
  const float radius = std::sqrt(nearest.distances[(i + 1) * nearest.count - 1]);
  Eigen::Matrix<float, 6, 6> normal_matrix = Eigen::Matrix<float, 6, 6>::Zero();
  Eigen::Matrix<float, 6, 1> right_side = Eigen::Matrix<float, 6, 1>::Zero();
  for (int j = 0; j < nearest.count; ++j) {
    const int neighbor = nearest.indices[i * nearest.count + j];
    const Eigen::Vector3f r = (points[neighbor] - points[i]) / radius;
    const float cosine = normals[neighbor].dot(n);
    const float alike = cosine * cosine;
    const float weight = std::exp(-kFalloff * r.squaredNorm()) * alike * alike;
    const auto terms = LocalSurface::terms(r.dot(surface.x), r.dot(surface.y));
    normal_matrix += weight * terms * terms.transpose();
    right_side += weight * r.dot(n) * terms;
  }
  normal_matrix.diagonal().array() += 1e-5f;  // all neighbours on a line
  surface.coefficients = normal_matrix.ldlt().solve(right_side);
  // From units of the radius to metres.
  surface.coefficients[0] *= radius;
  surface.coefficients.tail<3>() /= radius;
  return surface;
}

/// `points`, each moved onto the quadratic surfaces that fit best about it (moving least squares:
/// Alexa et al., "Computing and rendering point set surfaces", IEEE TVCG 2003). Curved surfaces
/// stay where they are; waves shorter than about ten spacings go, such as the steps of disparity
/// leave. All stay when there are too few.
Points smoothed(const Points& points, double spacing) {
  constexpr double kCoarser = 2;  // width of the voxels that are fitted, in spacings
  constexpr int kFitted = 36;
  constexpr int kOfNormal = 12;
  constexpr int kBlended = 3;
  const Points coarse = voxel_means(points, kCoarser * spacing);
  if (coarse.size() <= kFitted) return points;
  const Neighbors among = nearest_neighbors(coarse, kFitted);
  const std::vector<bool> all(coarse.size(), true);
  std::vector<Eigen::Vector3f> normals;
  std::vector<LocalSurface> surfaces;
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    normals.push_back(plane_normal(coarse, among, i, kOfNormal, all).cast<float>());
  }
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    surfaces.push_back(fitted_about(i, coarse, among, normals));
  }
  const auto farthest = static_cast<float>(kCoarser * spacing);
  const Neighbors nearest = nearest_neighbors(coarse, points, kBlended);
  Points result;
  result.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Vector3f step = Eigen::Vector3f::Zero();
    float sum = 0;
    for (int j = 0; j < kBlended; ++j) {
      const LocalSurface& surface = surfaces[nearest.indices[i * kBlended + j]];
      const float height = surface.over(points[i]);
      // A surface that is farther off is of another face.
      if (!(std::abs(height) <= farthest)) continue;
      const float weight = 1 / (nearest.distances[i * kBlended + j] + 0.01f * farthest * farthest);
      step += weight * height * surface.normal;
      sum += weight;
    }
    result.push_back(sum > 0 ? Eigen::Vector3f(points[i] + step / sum) : points[i]);
  }
  return result;
}

/// For each of `queries` what is far off from it on the outer side, as the normals of the shape's
/// points near it say; `otherwise` where they say nothing.
std::vector<Eigen::Vector3d> outer_sides(const Points& queries, const Points& points,
                                         const Points& normals, const Eigen::Vector3d& otherwise) {
  constexpr int kAsked = 4;
  constexpr double kFar = 100;  // m
  std::vector<Eigen::Vector3d> sides(queries.size(), otherwise);
  if (normals.empty() || queries.empty()) return sides;
  const Neighbors nearest =
      nearest_neighbors(points, queries, std::min(kAsked, static_cast<int>(points.size())));
  for (std::size_t i = 0; i < queries.size(); ++i) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int j = 0; j < nearest.count; ++j) sum += normals[nearest.indices[i * nearest.count + j]];
    if (sum.isZero()) continue;
    sides[i] = (queries[i] + kFar * sum).cast<double>();
  }
  return sides;
}

/// Points of one or several origins, and what their normals look at.
struct ThinnedPoints {
  Points points;
  std::vector<Eigen::Vector3d> viewpoints;
  std::vector<shape::PointOrigin> origins;
};

/// Appends the inliers of `thinned` with their normals. One search serves the filter and the
/// planes.
void append_oriented(const ThinnedPoints& thinned, const OrientedCloudOptions& options,
                     geometry::PointCloud& cloud, std::vector<shape::PointOrigin>& origins) {
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
    origins.push_back(thinned.origins[i]);
  }
}

}  // namespace

geometry::PointCloud oriented_cloud(const shape::CompletedShape& shape,
                                    const OrientedCloudOptions& options,
                                    std::vector<shape::PointOrigin>* origins) {
  if (!(options.spacing >= 0) || !std::isfinite(options.spacing)) {
    throw std::invalid_argument("OrientedCloudOptions.spacing must be >= 0");
  }
  if (!(options.least_spacing >= 0) || !std::isfinite(options.least_spacing)) {
    throw std::invalid_argument("OrientedCloudOptions.least_spacing must be >= 0");
  }
  const Points& points = shape.cloud_W.points;
  if (points.empty() || shape.origin.size() != points.size()) {
    throw InputError("the completed shape has no points, or not one origin per point",
                     "complete the shape again");
  }
  const std::size_t normal_count = shape.cloud_W.normals.size();
  if (normal_count != 0 && normal_count != points.size()) {
    throw InputError("the completed shape has not one normal per point",
                     "complete the shape again");
  }
  check(options.outliers);
  check(options.normals);
  check_finite(points);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) box.extend(p);
  const double extent = box.sizes().maxCoeff();
  const double spacing =
      options.spacing > 0 ? options.spacing : std::max(extent / 90.0, options.least_spacing);
  if (!(extent > 0)) {
    throw InputError("all points of the completed shape coincide", "segment the object again");
  }

  geometry::PointCloud cloud;
  std::vector<shape::PointOrigin> origin_of;
  ThinnedPoints thinned;
  for (const auto origin :
       {shape::PointOrigin::kSeen, shape::PointOrigin::kMirrored,
        shape::PointOrigin::kMirroredSecond, shape::PointOrigin::kMirroredBoth}) {
    Points made, normals;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (shape.origin[i] != origin) continue;
      made.push_back(points[i]);
      if (origin != shape::PointOrigin::kSeen && !shape.cloud_W.normals.empty()) {
        normals.push_back(shape.cloud_W.normals[i]);
      }
    }
    Points of_origin = voxel_means(made, spacing);
    if (options.smooth) of_origin = smoothed(of_origin, spacing);
    thinned.points.insert(thinned.points.end(), of_origin.begin(), of_origin.end());
    const std::vector<Eigen::Vector3d> viewpoints =
        outer_sides(of_origin, made, normals, shape.viewpoint_of(origin));
    thinned.viewpoints.insert(thinned.viewpoints.end(), viewpoints.begin(), viewpoints.end());
    thinned.origins.resize(thinned.points.size(), origin);
    const bool enough = thinned.points.size() > static_cast<std::size_t>(options.normals.neighbors);
    if (options.separate_origins && enough) {
      append_oriented(thinned, options, cloud, origin_of);
      thinned = {};
    }
  }
  if (!options.separate_origins) {
    check_enough(thinned.points.size(), options.normals.neighbors);
    append_oriented(thinned, options, cloud, origin_of);
  }
  if (origins) *origins = std::move(origin_of);
  return cloud;
}

}  // namespace prehend::surface
