#include "prehend/belief/displacement.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace prehend::belief {
namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3>;

Eigen::Vector3d center_of(const ShapeHypothesis& hypothesis) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : hypothesis.points.cloud_W.points) box.extend(p);
  return box.center().cast<double>();
}

/// The displacement of the observed points along their normals by a motion along the support: two
/// directions and a turn about its normal through the points' middle.
Rows motion_rows(const ShapeHypothesis& hypothesis, const geometry::Plane& table_W,
                 const std::vector<int>& points) {
  const geometry::PointCloud& cloud = hypothesis.points.cloud_W;
  const Eigen::Vector3d center = center_of(hypothesis);
  const Eigen::Vector3d x = table_W.normal.unitOrthogonal(), y = table_W.normal.cross(x);
  Rows rows(points.size(), 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d p = cloud.points[points[i]].cast<double>();
    const Eigen::Vector3d n = cloud.normals[points[i]].cast<double>();
    rows.row(static_cast<Eigen::Index>(i)) << n.dot(x), n.dot(y),
        n.dot(table_W.normal.cross(p - center));
  }
  return rows;
}

}  // namespace

Displacement::Displacement(const ShapeHypothesis& hypothesis, const geometry::Plane& table_W,
                           const std::vector<Motion>& motions,
                           std::vector<Observation> observations)
    : hypothesis_(hypothesis), up_W_(table_W.normal), observations_(std::move(observations)) {
  const auto count = static_cast<Eigen::Index>(observations_.size());
  Eigen::VectorXd found(count);
  for (const Observation& o : observations_) {
    if (o.point < 0 || o.point >= static_cast<int>(hypothesis.deviation.size()) ||
        !(o.deviation > 0) || !std::isfinite(o.displacement) || o.act < 0 ||
        o.act > static_cast<int>(motions.size())) {
      throw std::invalid_argument("Displacement: an observation is out of range");
    }
    found[static_cast<Eigen::Index>(observed_.size())] = o.displacement;
    observed_.push_back(o.point);
  }
  Eigen::MatrixXd covariance = prior_covariance(observed_, observed_);
  const Rows by_motion = motion_rows(hypothesis, table_W, observed_);
  std::vector<Rows> of_motions;  // zero for what was observed before
  for (std::size_t m = 0; m < motions.size(); ++m) {
    Rows rows = by_motion *
                Eigen::Vector3d(motions[m].along, motions[m].along, motions[m].turn).asDiagonal();
    for (Eigen::Index i = 0; i < count; ++i) {
      if (observations_[i].act <= static_cast<int>(m)) rows.row(i).setZero();
    }
    covariance += rows * rows.transpose();
    of_motions.push_back(std::move(rows));
  }
  // What the single precision of the points' covariance leaves open.
  constexpr double kRoundOff = 4e-6;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto deviation = static_cast<double>(hypothesis.deviation[observed_[i]]);
    covariance(i, i) +=
        observations_[i].deviation * observations_[i].deviation + kRoundOff * deviation * deviation;
  }
  solver_.compute(covariance);
  weights_ = solver_.solve(found);
  theta_ = rows(observed_).transpose() * weights_;
  center_W_ = center_of(hypothesis);
  for (std::size_t m = 0; m < motions.size(); ++m) {
    const Eigen::Vector3d of_one =
        Eigen::Vector3d(motions[m].along, motions[m].along, motions[m].turn)
            .cwiseProduct(of_motions[m].transpose() * weights_);
    const Eigen::Vector3d x = table_W.normal.unitOrthogonal(), y = table_W.normal.cross(x);
    moved_.push_back({of_one.x() * x + of_one.y() * y, of_one.z()});
  }
  if (count == 0) return;
  const double distance = found.dot(weights_);
  const Eigen::MatrixXd& factor = solver_.matrixLLT();
  const double log_determinant = 2 * factor.diagonal().array().log().sum();
  const auto n = static_cast<double>(count);
  log_likelihood_ = -0.5 * (distance + log_determinant + n * std::log(2 * std::numbers::pi));
  misfit_ = distance / n;
}

Eigen::Vector3d Displacement::before_motions(const Eigen::Vector3d& p_W, int act) const {
  Eigen::Vector3d p = p_W;
  for (int m = std::min(act, static_cast<int>(moved_.size())) - 1; m >= 0; --m) {
    p -= moved_[m].along_W + moved_[m].turn * up_W_.cross(p - center_W_);
  }
  return p;
}

Eigen::VectorXd Displacement::left_out_misfits() const {
  const auto count = static_cast<Eigen::Index>(observed_.size());
  const Eigen::MatrixXd inverse = solver_.solve(Eigen::MatrixXd::Identity(count, count));
  return weights_.array().square() / inverse.diagonal().array();
}

Eigen::MatrixXd Displacement::rows(const std::vector<int>& points) const {
  Eigen::MatrixXd result(points.size(), hypothesis_.motions.size());
  for (std::size_t k = 0; k < hypothesis_.motions.size(); ++k) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = static_cast<double>(
          hypothesis_.motions[k].col(points[i]).dot(hypothesis_.points.cloud_W.normals[points[i]]));
    }
  }
  return result;
}

Eigen::MatrixXd Displacement::residual_covariance(const std::vector<int>& points,
                                                  const std::vector<int>& others) const {
  const geometry::PointCloud& cloud = hypothesis_.points.cloud_W;
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::Matrix3Xf p(3, count), n(3, count);
  Eigen::ArrayXf deviation(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    p.col(i) = cloud.points[points[i]];
    n.col(i) = cloud.normals[points[i]];
    deviation[i] = hypothesis_.deviation[points[i]];
  }
  const auto scale_of = [](double length) { return static_cast<float>(-0.5 / (length * length)); };
  const float coarse = scale_of(hypothesis_.correlation_length);
  const float fine = scale_of(hypothesis_.detail_length);
  const auto detail = static_cast<float>(hypothesis_.detail);
  Eigen::MatrixXd covariance(count, others.size());
  for (std::size_t j = 0; j < others.size(); ++j) {
    const Eigen::ArrayXf alike =
        0.5f * (1 + (cloud.normals[others[j]].transpose() * n).transpose().array());
    const Eigen::ArrayXf squared =
        (p.colwise() - cloud.points[others[j]]).colwise().squaredNorm().transpose().array();
    const Eigen::ArrayXf near =
        (1 - detail) * (coarse * squared).exp() + detail * (fine * squared).exp();
    covariance.col(static_cast<Eigen::Index>(j)) =
        (hypothesis_.deviation[others[j]] * deviation * near * alike.square())
            .matrix()
            .cast<double>();
  }
  return covariance;
}

Eigen::MatrixXd Displacement::prior_covariance(const std::vector<int>& points,
                                               const std::vector<int>& others) const {
  return residual_covariance(points, others) + rows(points) * rows(others).transpose();
}

std::vector<Eigen::Vector3f> Displacement::places(const std::vector<int>& points) const {
  Eigen::VectorXd along = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(points.size()));
  if (!observed_.empty()) along = residual_covariance(points, observed_) * weights_;
  std::vector<Eigen::Vector3f> places;
  places.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Vector3f p = hypothesis_.points.cloud_W.points[points[i]];
    for (std::size_t k = 0; k < hypothesis_.motions.size(); ++k) {
      p += static_cast<float>(theta_[static_cast<Eigen::Index>(k)]) *
           hypothesis_.motions[k].col(points[i]);
    }
    places.push_back(p + static_cast<float>(along[static_cast<Eigen::Index>(i)]) *
                             hypothesis_.points.cloud_W.normals[points[i]]);
  }
  return places;
}

Eigen::VectorXd Displacement::variances(const std::vector<int>& points) const {
  Eigen::VectorXd variances = rows(points).rowwise().squaredNorm();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto deviation = static_cast<double>(hypothesis_.deviation[points[i]]);
    variances[static_cast<Eigen::Index>(i)] += deviation * deviation;
  }
  if (observed_.empty()) return variances;
  const Eigen::MatrixXd half =
      solver_.matrixL().solve(prior_covariance(points, observed_).transpose());
  variances -= half.colwise().squaredNorm().transpose();
  return variances.cwiseMax(0);
}

Eigen::VectorXd Displacement::covariances(const std::vector<int>& points, int with) const {
  Eigen::VectorXd covariance = prior_covariance(points, {with});
  if (observed_.empty()) return covariance;
  covariance -= prior_covariance(points, observed_) *
                solver_.solve(prior_covariance({with}, observed_).transpose());
  return covariance;
}

}  // namespace prehend::belief
