#include "prehend/belief/held_registration.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "prehend/belief/point_cells.h"

namespace prehend::belief {
namespace {

using geometry::RigidTransform;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kFarthest = 0.012, kNearest = 0.004;  // m, of a match, at first and at last
constexpr double kShrinks = 0.8;                       // of a round to the next
constexpr int kRounds = 24;
constexpr double kNoise = 0.0015;       // m, of a seen point along the normal
constexpr double kIndependent = 60;     // points: neighbours err alike
constexpr float kAlike = 0.7F;          // cosine of normals
constexpr std::size_t kMostSeen = 800;  // that are matched
constexpr double kSettled = 1e-6;       // m and rad, of a round's correction

RigidTransform about(const Eigen::Vector3d& center, const Vector6& change) {
  const Eigen::Vector3d turn = change.head<3>();
  const double angle = turn.norm();
  RigidTransform X = RigidTransform::Identity();
  if (angle > 0) X.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  X.translation() = center - X.linear() * center + change.tail<3>();
  return X;
}

/// The change that about() makes `X` of.
Vector6 change_of(const Eigen::Vector3d& center, const RigidTransform& X) {
  const Eigen::AngleAxisd turn(X.linear());
  Vector6 change;
  change.head<3>() = turn.angle() * turn.axis();
  change.tail<3>() = X * center - center;
  return change;
}

void check(const geometry::PointCloud& cloud) {
  if (cloud.normals.size() != cloud.points.size()) {
    throw std::invalid_argument("held_pose(): points have no normals");
  }
}

}  // namespace

HeldPose held_pose(const geometry::PointCloud& known_K, const geometry::PointCloud& seen_S,
                   const HeldPrior& prior) {
  check(known_K);
  check(seen_S);
  if (!(prior.along > 0) || !(prior.turn > 0) || !std::isfinite(prior.along + prior.turn)) {
    throw std::invalid_argument("held_pose(): the prior is no standard deviation");
  }
  HeldPose result;
  if (known_K.empty() || seen_S.empty()) return result;
  const PointCells cells(known_K.points, kFarthest);
  const Eigen::Vector3d center = geometry::centroid(seen_S);
  const std::size_t step = 1 + (seen_S.size() - 1) / kMostSeen;
  Vector6 precision;
  precision.head<3>().setConstant(1 / (prior.turn * prior.turn));
  precision.tail<3>().setConstant(1 / (prior.along * prior.along));
  double reach = kFarthest;
  for (int round = 0; round < kRounds; ++round, reach = std::max(kNearest, kShrinks * reach)) {
    Matrix6 information = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    std::size_t matched = 0;
    double squares = 0;
    const Eigen::Vector3d now = result.X_KS * center;
    const auto farthest = static_cast<float>(reach * reach);
    for (std::size_t i = 0; i < seen_S.size(); i += step) {
      const Eigen::Vector3d p = result.X_KS * seen_S.points[i].cast<double>();
      const Eigen::Vector3f n =
          (result.X_KS.linear() * seen_S.normals[i].cast<double>()).cast<float>();
      float least = farthest;
      std::size_t nearest = known_K.size();
      cells.each_near(p.cast<float>(), [&](std::size_t k, float squared) {
        if (squared >= least || known_K.normals[k].dot(n) < kAlike) return;
        least = squared;
        nearest = k;
      });
      if (nearest == known_K.size()) continue;
      const Eigen::Vector3d normal = known_K.normals[nearest].cast<double>();
      const double off = normal.dot(p - known_K.points[nearest].cast<double>());
      Vector6 slope;
      slope.head<3>() = (p - now).cross(normal);
      slope.tail<3>() = normal;
      information += slope * slope.transpose();
      right -= off * slope;
      squares += off * off;
      ++matched;
    }
    result.matched = matched * step;
    result.residual = matched > 0 ? std::sqrt(squares / static_cast<double>(matched)) : 0;
    const double share =
        matched > 0 ? std::min(1.0, kIndependent / static_cast<double>(matched)) : 0;
    const double weight = share / (kNoise * kNoise);
    const Vector6 so_far = change_of(center, result.X_KS);
    Matrix6 all = weight * information;
    all.diagonal() += precision;
    const Vector6 change = all.ldlt().solve(weight * right - precision.cwiseProduct(so_far));
    result.X_KS = about(now, change) * result.X_KS;
    if (change.norm() < kSettled && reach <= kNearest) break;
  }
  return result;
}

}  // namespace prehend::belief
