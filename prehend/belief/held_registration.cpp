#include "prehend/belief/held_registration.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "prehend/belief/point_cells.h"

namespace prehend::belief {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kFarthest = 0.012, kNearest = 0.004;  // m, of a match, at first and at last
constexpr double kShrinks = 0.8;                       // of a round to the next
constexpr int kRounds = 20;
constexpr double kNoise = 0.0015;       // m, of a seen point along the normal
constexpr double kIndependent = 12;     // points of a look: neighbours err alike
constexpr float kAlike = 0.7F;          // cosine of normals
constexpr std::size_t kMostSeen = 500;  // of a look, that are matched
constexpr double kSettled = 1e-6;       // m and rad, of a round's correction

/// A turn (first three) and a way of what is at `center`.
RigidTransform about(const Vector3d& center, const Vector6& change) {
  const Vector3d turn = change.head<3>();
  const double angle = turn.norm();
  RigidTransform X = RigidTransform::Identity();
  if (angle > 0) X.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  X.translation() = center - X.linear() * center + change.tail<3>();
  return X;
}

/// The change that about() makes `X` of.
Vector6 change_of(const Vector3d& center, const RigidTransform& X) {
  const Eigen::AngleAxisd turn(X.linear());
  Vector6 change;
  change.head<3>() = turn.angle() * turn.axis();
  change.tail<3>() = X * center - center;
  return change;
}

Vector6 precision_of(const HeldPrior& prior) {
  if (!(prior.along > 0) || !(prior.turn > 0) || !std::isfinite(prior.along + prior.turn)) {
    throw std::invalid_argument("held_poses(): the prior is no standard deviation");
  }
  Vector6 precision;
  precision.head<3>().setConstant(1 / (prior.turn * prior.turn));
  precision.tail<3>().setConstant(1 / (prior.along * prior.along));
  return precision;
}

void check(const geometry::PointCloud& cloud) {
  if (cloud.normals.size() != cloud.points.size()) {
    throw std::invalid_argument("held_poses(): points have no normals");
  }
}

/// The looks and what was known before them, and the system of their poses.
class Registration {
 public:
  Registration(const geometry::PointCloud& known_K,
               const std::vector<geometry::PointCloud>& looks_S, const HeldPrior& closing,
               const HeldPrior& holding)
      : known_(known_K),
        looks_(looks_S),
        closing_(precision_of(closing)),
        holding_(precision_of(holding)),
        poses_(looks_S.size()) {
    check(known_K);
    for (const geometry::PointCloud& look : looks_S) check(look);
    center_ = geometry::centroid(known_K.empty() && !looks_S.empty() ? looks_S.front() : known_K);
  }

  std::vector<HeldPose> solve() {
    double reach = kFarthest;
    for (int round = 0; round < kRounds && !looks_.empty(); ++round) {
      const double moved = improve(reach);
      if (moved < kSettled && reach <= kNearest) break;
      reach = std::max(kNearest, kShrinks * reach);
    }
    return std::move(poses_);
  }

 private:
  static constexpr int kKnown = -1;  // in place of a look's number

  Eigen::Index at(int look) const { return 6 * static_cast<Eigen::Index>(look); }

  /// One round for all looks; how far it has moved any of them.
  double improve(double reach) {
    const Eigen::Index size = 6 * static_cast<Eigen::Index>(looks_.size());
    hessian_.setZero(size, size);
    right_.setZero(size);
    std::vector<geometry::PointCloud> placed;
    for (std::size_t i = 0; i < looks_.size(); ++i) {
      placed.push_back(geometry::transformed(looks_[i], poses_[i].X_KS));
    }
    for (std::size_t i = 0; i < looks_.size(); ++i) add_matches(static_cast<int>(i), placed, reach);
    add_priors();
    const Eigen::VectorXd change = hessian_.ldlt().solve(right_);
    for (std::size_t i = 0; i < looks_.size(); ++i) {
      const Vector6 own = change.segment<6>(at(static_cast<int>(i)));
      poses_[i].X_KS = about(center_, own) * poses_[i].X_KS;
    }
    return change.cwiseAbs().maxCoeff();
  }

  /// The points of look `i` beside those of all others.
  void add_matches(int i, const std::vector<geometry::PointCloud>& placed, double reach) {
    const geometry::PointCloud& own = placed[static_cast<std::size_t>(i)];
    HeldPose& pose = poses_[static_cast<std::size_t>(i)];
    const std::size_t step = 1 + (own.size() - 1) / kMostSeen;
    double squares = 0;
    std::size_t matched = 0;
    struct Match {
      int other;
      Vector3d p, normal;
      double off;
    };
    std::vector<Match> matches;
    for (int j = kKnown; j < static_cast<int>(placed.size()); ++j) {
      if (j == i) continue;
      const geometry::PointCloud& other =
          j == kKnown ? known_ : placed[static_cast<std::size_t>(j)];
      const PointCells cells(other.points, reach);
      for (std::size_t k = 0; k < own.size(); k += step) {
        float least = static_cast<float>(reach * reach);
        std::size_t nearest = other.size();
        cells.each_near(own.points[k], [&](std::size_t n, float squared) {
          if (squared >= least || other.normals[n].dot(own.normals[k]) < kAlike) return;
          least = squared;
          nearest = n;
        });
        if (nearest == other.size()) continue;
        const Vector3d p = own.points[k].cast<double>();
        const Vector3d normal = other.normals[nearest].cast<double>();
        const double off = normal.dot(p - other.points[nearest].cast<double>());
        matches.push_back({j, p, normal, off});
        squares += off * off;
        ++matched;
      }
    }
    pose.matched = matched * step;
    pose.residual = matched > 0 ? std::sqrt(squares / static_cast<double>(matched)) : 0;
    if (matches.empty()) return;
    const double share = std::min(1.0, kIndependent / static_cast<double>(matches.size()));
    const double weight = share / (kNoise * kNoise);
    for (const Match& match : matches) {
      Vector6 slope;
      slope.head<3>() = (match.p - center_).cross(match.normal);
      slope.tail<3>() = match.normal;
      add(i, match.other, slope, match.off, weight);
    }
  }

  /// A residual `off` that grows by `slope` with the change of look i, and shrinks with that of j.
  void add(int i, int j, const Vector6& slope, double off, double weight) {
    const Eigen::Matrix<double, 6, 6> block = weight * slope * slope.transpose();
    hessian_.block<6, 6>(at(i), at(i)) += block;
    right_.segment<6>(at(i)) -= weight * off * slope;
    if (j == kKnown) return;
    hessian_.block<6, 6>(at(j), at(j)) += block;
    hessian_.block<6, 6>(at(i), at(j)) -= block;
    hessian_.block<6, 6>(at(j), at(i)) -= block;
    right_.segment<6>(at(j)) += weight * off * slope;
  }

  void add_priors() {
    Vector6 before = Vector6::Zero();
    for (int i = 0; i < static_cast<int>(looks_.size()); ++i) {
      const Vector6 now = change_of(center_, poses_[static_cast<std::size_t>(i)].X_KS);
      for (int k = 0; k < 6; ++k) {
        Vector6 slope = Vector6::Zero();
        slope[k] = 1;
        add(i, i == 0 ? kKnown : i - 1, slope, now[k] - before[k],
            i == 0 ? closing_[k] : holding_[k]);
      }
      before = now;
    }
  }

  const geometry::PointCloud& known_;
  const std::vector<geometry::PointCloud>& looks_;
  Vector6 closing_, holding_;
  std::vector<HeldPose> poses_;
  Vector3d center_ = Vector3d::Zero();  // that turns are about
  Eigen::MatrixXd hessian_;
  Eigen::VectorXd right_;
};

}  // namespace

std::vector<HeldPose> held_poses(const geometry::PointCloud& known_K,
                                 const std::vector<geometry::PointCloud>& looks_S,
                                 const HeldPrior& closing, const HeldPrior& holding) {
  return Registration(known_K, looks_S, closing, holding).solve();
}

}  // namespace prehend::belief
