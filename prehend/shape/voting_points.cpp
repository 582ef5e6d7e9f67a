#include "prehend/shape/voting_points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>
#include <opencv2/imgproc.hpp>

#include "prehend/geometry/errors.h"

namespace prehend::shape {
namespace {

using geometry::InputError;

constexpr int kLeastPoints = 10;
constexpr double kFlat = 0.01;  // spread across over spread along, below which points are flat

geometry::RigidTransform camera_table_frame(const ObjectView& view) {
  const Eigen::Vector3d z = view.table_W.normal;
  if (!(std::abs(z.norm() - 1) < 1e-6) || !std::isfinite(view.table_W.offset)) {
    throw InputError("the table's normal is not a unit vector", "find the table again");
  }
  // A camera that looks straight down has its image's top as forward direction.
  Eigen::Vector3d forward = view.X_WC.linear().col(2);
  forward -= z * z.dot(forward);
  if (forward.norm() < 0.05) {
    forward = -view.X_WC.linear().col(1);
    forward -= z * z.dot(forward);
  }
  if (!(forward.norm() > 1e-6)) {
    throw InputError("the camera's pose is not a rigid transform", "check the camera's pose");
  }
  const Eigen::Vector3d x = forward.normalized();
  geometry::RigidTransform X_WT = geometry::RigidTransform::Identity();
  X_WT.linear() << x, z.cross(x), z;
  X_WT.translation() = view.table_W.project(view.X_WC.translation());
  return X_WT;
}

bool less(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

/// Means of the points in each voxel, in the voxels' order.
std::vector<Eigen::Vector3d> one_per_voxel(const std::vector<Eigen::Vector3d>& points,
                                           const Eigen::AlignedBox3d& box, double side) {
  // 21 bits a coordinate: at most 1 / least thinning voxels a side, far below.
  const auto key_of = [&](const Eigen::Vector3d& p) {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k) {
      const double cell = std::floor((p(k) - box.min()(k)) / side);
      key = key << 21 | static_cast<std::uint64_t>(std::clamp(cell, 0.0, 2097151.0));
    }
    return key;
  };
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
  keyed.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    keyed.emplace_back(key_of(points[i]), static_cast<std::uint32_t>(i));
  }
  std::sort(keyed.begin(), keyed.end());
  // The mean, not the first: it lies near the surface's middle within the voxel. Summed in the
  // order of the coordinates, so that the input's order does not matter.
  std::vector<Eigen::Vector3d> kept, voxel;
  for (std::size_t begin = 0, end = 0; begin < keyed.size(); begin = end) {
    voxel.clear();
    for (end = begin; end < keyed.size() && keyed[end].first == keyed[begin].first; ++end) {
      voxel.push_back(points[keyed[end].second]);
    }
    std::sort(voxel.begin(), voxel.end(), less);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : voxel) sum += p;
    kept.push_back(sum / static_cast<double>(voxel.size()));
  }
  return kept;
}

void check_spread(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d spread = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  // Below single precision at that distance the spread is rounding.
  if (!(spread(2) > 1e-7 * mean.norm() * std::sqrt(static_cast<double>(points.size())))) {
    throw InputError("all seen points of the object coincide", "segment the object again");
  }
  if (spread(1) < kFlat * spread(2)) {
    throw InputError("the seen points of the object lie on a line", "look from another side");
  }
  if (spread(0) < kFlat * spread(2)) {
    throw InputError("the seen points of the object lie in one plane",
                     "look from another side, so that more than one face is seen");
  }
}

}  // namespace

VotingPoints make_voting_points(const ObjectView& view, double thinning) {
  const auto& points_W = view.cloud_W.points;
  if (points_W.size() < kLeastPoints) {
    throw InputError("the object has " + std::to_string(points_W.size()) + " seen points",
                     "give at least " + std::to_string(kLeastPoints));
  }
  VotingPoints result;
  result.X_WT = camera_table_frame(view);
  const geometry::RigidTransform X_TW = result.X_WT.inverse();
  std::vector<Eigen::Vector3d> points_T;
  points_T.reserve(points_W.size());
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p_W : points_W) {
    if (!geometry::is_finite(p_W)) {
      throw InputError("a seen point of the object is not finite", "remove invalid points");
    }
    points_T.push_back(X_TW * p_W.cast<double>());
    box.extend(points_T.back());
  }
  if (!(box.sizes().maxCoeff() > 0)) {
    throw InputError("all seen points of the object coincide", "segment the object again");
  }
  result.extent = box.sizes().head<2>().maxCoeff();
  const double side = box.sizes().maxCoeff();
  if (thinning > 0) {
    result.points_T = one_per_voxel(points_T, box, thinning * side);
  } else {
    result.points_T = points_T;
    std::sort(result.points_T.begin(), result.points_T.end(), less);
  }
  result.coarse_points_T = one_per_voxel(result.points_T, box, std::max(3 * thinning, 0.03) * side);
  check_spread(result.points_T);
  if (box.contains(X_TW * view.X_WC.translation())) {
    throw InputError("the viewpoint lies within the object's seen points",
                     "check the camera's pose, or look from further away");
  }

  for (const Eigen::Vector3d& p : result.points_T) result.center_T += p;
  result.center_T /= static_cast<double>(result.points_T.size());
  // The camera's foot is T's origin; from straight above the camera's forward direction serves.
  const Eigen::Vector2d center = result.center_T.head<2>();
  if (center.norm() > 0.05 * result.extent) result.away_T = center.normalized();
  return result;
}

std::vector<Eigen::Vector2d> starting_normals(const VotingPoints& points, bool first_only) {
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  std::vector<cv::Point2f> footprint;
  for (const Eigen::Vector3d& p : points.points_T) {
    const Eigen::Vector2d r = (p - points.center_T).head<2>();
    covariance += r * r.transpose();
    footprint.emplace_back(static_cast<float>(r.x() / points.extent),
                           static_cast<float>(r.y() / points.extent));
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  const Eigen::Matrix2d axes = solver.computeDirect(covariance).eigenvectors();
  const auto away = [&](const Eigen::Vector2d& n) -> Eigen::Vector2d {
    return n.dot(points.away_T) < 0 ? -n : n;
  };
  std::vector<Eigen::Vector2d> normals{away(axes.col(0)), away(axes.col(1))};
  if (normals[0].dot(points.away_T) < normals[1].dot(points.away_T)) {
    std::swap(normals[0], normals[1]);
  }
  if (first_only) {
    normals.resize(1);
    return normals;
  }
  const double angle = cv::minAreaRect(footprint).angle * CV_PI / 180;
  const Eigen::Vector2d side(std::cos(angle), std::sin(angle));
  normals.push_back(away(side));
  normals.push_back(away(Eigen::Vector2d(-side.y(), side.x())));
  return normals;
}

}  // namespace prehend::shape
