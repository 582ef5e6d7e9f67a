#include "prehend/surface/normals.h"

#include <algorithm>
#include <array>
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

/// Means of the points in each cubic voxel, in the order of the voxels.
Points voxel_means(Points points, double side) {
  using Key = std::array<std::int64_t, 3>;
  std::vector<std::pair<Key, Eigen::Vector3f>> keyed;
  keyed.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Array3d cell = (p.cast<double>().array() / side).floor();
    keyed.push_back({{static_cast<std::int64_t>(cell.x()), static_cast<std::int64_t>(cell.y()),
                      static_cast<std::int64_t>(cell.z())},
                     p});
  }
  std::stable_sort(keyed.begin(), keyed.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  points.clear();
  for (std::size_t begin = 0, end = 0; begin < keyed.size(); begin = end) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (end = begin; end < keyed.size() && keyed[end].first == keyed[begin].first; ++end) {
      sum += keyed[end].second.cast<double>();
    }
    points.push_back((sum / static_cast<double>(end - begin)).cast<float>());
  }
  return points;
}

}  // namespace

std::vector<int> without_outliers(const Points& points, const OutlierOptions& options) {
  if (options.neighbors < 1 || !(options.deviations > 0)) {
    throw std::invalid_argument("OutlierOptions: neighbors must be >= 1 and deviations > 0");
  }
  check_finite(points);
  std::vector<int> kept;
  const int count = options.neighbors + 1;
  if (points.size() < static_cast<std::size_t>(count)) {
    for (std::size_t i = 0; i < points.size(); ++i) kept.push_back(static_cast<int>(i));
    return kept;
  }
  const Neighbors nearest = nearest_neighbors(points, count);
  std::vector<double> mean_distance(points.size(), 0);
  double sum = 0;
  double sum_of_squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int j = 1; j < count; ++j) mean_distance[i] += std::sqrt(nearest.distances[i * count + j]);
    mean_distance[i] /= options.neighbors;
    sum += mean_distance[i];
    sum_of_squares += mean_distance[i] * mean_distance[i];
  }
  const double mean = sum / static_cast<double>(points.size());
  const double variance = sum_of_squares / static_cast<double>(points.size()) - mean * mean;
  const double limit = mean + options.deviations * std::sqrt(std::max(0.0, variance));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (mean_distance[i] <= limit) kept.push_back(static_cast<int>(i));
  }
  return kept;
}

std::vector<Eigen::Vector3f> estimate_normals(const Points& points,
                                              const std::vector<Eigen::Vector3d>& viewpoints,
                                              const NormalOptions& options) {
  if (options.neighbors < 3) throw std::invalid_argument("NormalOptions.neighbors must be >= 3");
  if (viewpoints.size() != points.size()) {
    throw std::invalid_argument("estimate_normals: one viewpoint per point is needed");
  }
  check_finite(points);
  const int count = options.neighbors + 1;
  if (points.size() < static_cast<std::size_t>(count)) {
    throw InputError("the cloud has " + std::to_string(points.size()) + " points, too few for " +
                         std::to_string(options.neighbors) + " neighbours each",
                     "give more points or fewer neighbours");
  }
  const Neighbors nearest = nearest_neighbors(points, count);
  std::vector<Eigen::Vector3f> normals(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int* indices = &nearest.indices[i * count];
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (int j = 0; j < count; ++j) mean += points[indices[j]].cast<double>();
    mean /= count;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (int j = 0; j < count; ++j) {
      const Eigen::Vector3d r = points[indices[j]].cast<double>() - mean;
      covariance += r * r.transpose();
    }
    // Scaled, so that tiny clouds do not underflow in the solver's tolerance.
    const double scale = covariance.trace();
    if (scale > 0) covariance /= scale;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    Eigen::Vector3d n = solver.eigenvectors().col(0);
    if (n.dot(viewpoints[i] - points[i].cast<double>()) < 0) n = -n;
    normals[i] = n.cast<float>();
  }
  return normals;
}

geometry::PointCloud oriented_cloud(const shape::CompletedShape& shape,
                                    const OrientedCloudOptions& options) {
  if (!(options.spacing >= 0) || !std::isfinite(options.spacing)) {
    throw std::invalid_argument("OrientedCloudOptions.spacing must be >= 0");
  }
  const Points& points = shape.cloud_W.points;
  if (points.empty() || shape.origin.size() != points.size()) {
    throw InputError("the completed shape has no points, or not one origin per point",
                     "complete the shape again");
  }
  check_finite(points);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) box.extend(p);
  const double spacing = options.spacing > 0 ? options.spacing : box.sizes().maxCoeff() / 90.0;
  if (!(spacing > 0)) {
    throw InputError("all points of the completed shape coincide", "segment the object again");
  }

  Points thinned;
  std::vector<Eigen::Vector3d> viewpoints;
  for (const auto origin :
       {shape::PointOrigin::kSeen, shape::PointOrigin::kMirrored,
        shape::PointOrigin::kMirroredSecond, shape::PointOrigin::kMirroredBoth}) {
    Points of_origin;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (shape.origin[i] == origin) of_origin.push_back(points[i]);
    }
    of_origin = voxel_means(std::move(of_origin), spacing);
    thinned.insert(thinned.end(), of_origin.begin(), of_origin.end());
    viewpoints.resize(thinned.size(), shape.viewpoint_of(origin));
  }

  geometry::PointCloud cloud;
  std::vector<Eigen::Vector3d> kept_viewpoints;
  for (const int i : without_outliers(thinned, options.outliers)) {
    cloud.points.push_back(thinned[i]);
    kept_viewpoints.push_back(viewpoints[i]);
  }
  cloud.normals = estimate_normals(cloud.points, kept_viewpoints, options.normals);
  return cloud;
}

}  // namespace prehend::surface
