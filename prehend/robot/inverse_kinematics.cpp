#include "prehend/robot/inverse_kinematics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace prehend::robot {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr double kPi = std::numbers::pi;
constexpr double kMeet = 1e-7;       // m: axes nearer than this meet
constexpr double kParallel = 1e-7;   // sine
constexpr double kTouching = 1e-10;  // relative: a double root, rounded to none
constexpr double kSingular = 1e-8;   // sine

Matrix3d turn(const Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

/// The angles that solve a cos + b sin = c: none, or two (which may be equal).
struct Roots {
  int count = 0;
  std::array<double, 2> angle{};
};

Roots solve_cosine(double a, double b, double c) {
  const double length = std::hypot(a, b);
  Roots roots;
  if (!(length > 0)) return roots;
  double cosine = c / length;
  if (std::abs(cosine) > 1) {
    if (std::abs(cosine) > 1 + kTouching) return roots;
    cosine = std::copysign(1.0, cosine);
  }
  const double middle = std::atan2(b, a), half = std::acos(cosine);
  roots.count = 2;
  roots.angle = {middle + half, middle - half};
  return roots;
}

/// Angle about `axis` (unit) that turns the part of `from` across it to that of `to`.
double angle_about(const Vector3d& axis, const Vector3d& from, const Vector3d& to) {
  return std::atan2(axis.dot(from.cross(to)), from.dot(to) - axis.dot(from) * axis.dot(to));
}

struct ThreeAngles {
  std::array<double, 3> angle{};
};

/// Up to two ways to write `rotation` as turns about a, then b, then c (R = R_a R_b R_c). Where a
/// and the turned c coincide, the first angle is `first`.
struct ThreeAxes {
  int count = 0;
  bool singular = false;
  std::array<ThreeAngles, 2> ways{};
};

ThreeAxes decompose(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                    const Matrix3d& rotation, double first) {
  const Vector3d v = rotation * c;
  const double constant = a.dot(b) * b.dot(c);
  const Roots roots = solve_cosine(a.dot(c) - constant, a.dot(b.cross(c)), a.dot(v) - constant);
  ThreeAxes result;
  const Vector3d across = c.unitOrthogonal();
  const Vector3d turned = rotation * across;
  for (int i = 0; i < roots.count; ++i) {
    ThreeAngles& way = result.ways[static_cast<std::size_t>(result.count)];
    way.angle[1] = roots.angle[static_cast<std::size_t>(i)];
    const Matrix3d R_b = turn(b, way.angle[1]);
    const Vector3d w = R_b * c;
    const bool singular = a.cross(w).norm() < kSingular;
    way.angle[0] = singular ? first : angle_about(a, w, v);
    way.angle[2] = angle_about(c, across, R_b.transpose() * (turn(a, -way.angle[0]) * turned));
    result.singular = result.singular || singular;
    ++result.count;
    // Both roots are one there.
    if (singular) break;
  }
  return result;
}

/// Where three lines meet; none when they do not.
bool meet(const Vector3d* points, const Vector3d* axes, Vector3d& where) {
  Matrix3d sum = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Matrix3d across = Matrix3d::Identity() - axes[i] * axes[i].transpose();
    sum += across;
    right += across * points[i];
  }
  // Parallel lines meet everywhere or nowhere: no spherical joint.
  if (axes[0].cross(axes[1]).norm() < kParallel || axes[1].cross(axes[2]).norm() < kParallel) {
    return false;
  }
  where = sum.ldlt().solve(right);
  for (int i = 0; i < 3; ++i) {
    if ((where - points[i]).cross(axes[i]).norm() > kMeet) return false;
  }
  return true;
}

}  // namespace

/// Turns what was computed into answers.
struct InverseKinematics::Collector {
  const KinematicChain& chain;
  const Eigen::Ref<const Eigen::VectorXd>& seed;
  InverseAnswer answer{};
  int beyond = 0;            // solutions that the limits forbid
  Positions least_beyond{};  // the one that they forbid by the least
  double least = std::numeric_limits<double>::infinity();
  std::string unreachable{};
  double out_of_reach = 0;  // m
  InverseFailure failure = InverseFailure::kOutOfReach;

  /// Turns revolute joints by whole turns to within their limits; keeps what is.
  void add(Positions q) {
    double worst = 0;
    for (int i = 0; i < chain.size(); ++i) {
      const ChainJoint& joint = chain.joints()[static_cast<std::size_t>(i)];
      if (joint.is_revolute) {
        q[i] = seed[i] + std::remainder(q[i] - seed[i], 2 * kPi);
        if (q[i] > joint.upper + 1e-9 && q[i] - 2 * kPi >= joint.lower - 1e-9) q[i] -= 2 * kPi;
        if (q[i] < joint.lower - 1e-9 && q[i] + 2 * kPi <= joint.upper + 1e-9) q[i] += 2 * kPi;
      }
      worst = std::max({worst, joint.lower - q[i], q[i] - joint.upper});
    }
    if (worst <= 1e-9) {
      answer.solutions.push_back(q);
      return;
    }
    ++beyond;
    if (worst < least) {
      least = worst;
      least_beyond = q;
    }
  }

  InverseAnswer finish() {
    std::stable_sort(answer.solutions.begin(), answer.solutions.end(),
                     [this](const Positions& a, const Positions& b) {
                       return (a - seed).squaredNorm() < (b - seed).squaredNorm();
                     });
    if (!answer.solutions.empty()) return std::move(answer);
    answer.failure = beyond > 0 ? InverseFailure::kBeyondLimits : failure;
    answer.miss = beyond > 0 ? least : out_of_reach;
    if (beyond > 0) {
      answer.reason = std::to_string(beyond) +
                      " solutions are beyond the limits; in the nearest, " +
                      chain.limit_problem(least_beyond);
    } else {
      answer.reason = unreachable.empty() ? "out of reach" : unreachable;
    }
    return std::move(answer);
  }
};

InverseKinematics::InverseKinematics(KinematicChain chain, const InverseOptions& options)
    : chain_(std::move(chain)), options_(options), middle_(chain_.middle()) {
  if (options.elbow_angles < 1) throw std::invalid_argument("InverseOptions.elbow_angles < 1");
  if (options.restarts < 0) throw std::invalid_argument("InverseOptions.restarts < 0");
  if (options.iterations < 1) throw std::invalid_argument("InverseOptions.iterations < 1");
  if (!(options.tolerance > 0)) throw std::invalid_argument("InverseOptions.tolerance <= 0");
  method_ = classify();
}

InverseMethod InverseKinematics::classify() {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(chain_.size());
  std::vector<RigidTransform> poses;
  chain_.forward(zero, poses);
  bool revolute = true;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    axis_.push_back(poses[i].linear() * chain_.joints()[i].axis_J);
    point_.push_back(poses[i].translation());
    revolute = revolute && chain_.joints()[i].is_revolute;
  }
  X_TB_ = chain_.forward(zero).inverse();
  const std::size_t n = poses.size();
  if (!revolute || n < 6 || n > 7 || !meet(&point_[n - 3], &axis_[n - 3], wrist_)) {
    return InverseMethod::kNumeric;
  }
  if (n == 7) {
    const bool spherical = meet(point_.data(), axis_.data(), shoulder_);
    const auto off = [this](const Vector3d& p) { return (p - point_[3]).cross(axis_[3]).norm(); };
    return spherical && off(shoulder_) > kMeet && off(wrist_) > kMeet
               ? InverseMethod::kSphericalShoulderAndWrist
               : InverseMethod::kNumeric;
  }
  const bool fits = axis_[1].cross(axis_[2]).norm() < kParallel &&
                    axis_[0].cross(axis_[1]).norm() > kParallel &&
                    (point_[2] - point_[1]).cross(axis_[1]).norm() > kMeet &&
                    (wrist_ - point_[2]).cross(axis_[2]).norm() > kMeet;
  return fits ? InverseMethod::kSphericalWrist : InverseMethod::kNumeric;
}

InverseAnswer InverseKinematics::solve(const RigidTransform& X_BT,
                                       const Eigen::Ref<const Eigen::VectorXd>& seed) const {
  if (seed.size() != chain_.size()) {
    throw std::invalid_argument("InverseKinematics::solve: the seed needs " +
                                std::to_string(chain_.size()) + " positions");
  }
  if (!X_BT.matrix().allFinite() || !seed.allFinite()) {
    throw std::invalid_argument("InverseKinematics::solve: pose and seed must be finite");
  }
  Collector found{chain_, seed};
  switch (method_) {
    case InverseMethod::kSphericalWrist:
      found.answer.solutions.reserve(8);
      spherical_wrist(X_BT, found);
      break;
    case InverseMethod::kSphericalShoulderAndWrist:
      shoulder_and_wrist(X_BT, found);
      break;
    case InverseMethod::kNumeric:
      numeric(X_BT, found);
      break;
  }
  return found.finish();
}

// With E_i(q) the motion of everything beyond joint i, X_BT = E_1 ... E_n X_BT(0). The wrist's
// centre c stays under E_4 E_5 E_6, so that E_1 E_2 E_3 c = p is known; E_2 E_3 move it across
// their common axis only, which gives q_1, and the rest is a triangle.
void InverseKinematics::spherical_wrist(const RigidTransform& X_BT, Collector& found) const {
  const RigidTransform motion = X_BT * X_TB_;
  const Vector3d p = motion * wrist_;
  const Vector3d &h1 = axis_[0], &h2 = axis_[1], &h3 = axis_[2];
  const Vector3d u = p - point_[0];
  const double along = h1.dot(u) * h1.dot(h2);
  const Vector3d flat = u - h1.dot(u) * h1;
  const Roots first =
      solve_cosine(h2.dot(flat), h1.cross(h2).dot(flat), h2.dot(wrist_ - point_[0]) - along);
  const Vector3d upper = point_[2] - point_[1] - h2 * h2.dot(point_[2] - point_[1]);
  const Vector3d lower = wrist_ - point_[2] - h2 * h2.dot(wrist_ - point_[2]);
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < first.count; ++i) {
    Positions q(6);
    q[0] = first.angle[static_cast<std::size_t>(i)];
    const Matrix3d R1 = turn(h1, q[0]);
    const Vector3d y = point_[0] + R1.transpose() * u - point_[1];
    const Vector3d target = y - h2 * h2.dot(y);
    nearest = std::min(nearest, target.norm());
    const double rest = 0.5 * (target.squaredNorm() - upper.squaredNorm() - lower.squaredNorm());
    const Roots third = solve_cosine(upper.dot(lower), upper.dot(h3.cross(lower)), rest);
    for (int j = 0; j < third.count; ++j) {
      q[2] = third.angle[static_cast<std::size_t>(j)];
      const Matrix3d R3 = turn(h3, q[2]);
      q[1] = angle_about(h2, upper + R3 * lower, target);
      const Matrix3d R123 = R1 * turn(h2, q[1]) * R3;
      const ThreeAxes wrist = decompose(axis_[3], axis_[4], axis_[5],
                                        R123.transpose() * motion.linear(), found.seed[3]);
      found.answer.singular = found.answer.singular || wrist.singular;
      for (int k = 0; k < wrist.count; ++k) {
        for (int m = 0; m < 3; ++m) q[3 + m] = wrist.ways[static_cast<std::size_t>(k)].angle[m];
        found.add(q);
      }
    }
  }
  if (first.count == 0) {
    found.out_of_reach = std::abs(h2.dot(wrist_ - point_[0]) - along) - flat.norm();
    found.unreachable = "out of reach: the wrist would be too near to the first axis";
  } else {
    const double closest = std::abs(upper.norm() - lower.norm());
    const double farthest = upper.norm() + lower.norm();
    found.out_of_reach = std::max(closest - nearest, nearest - farthest);
    char text[160];
    std::snprintf(text, sizeof text,
                  "out of reach: the wrist would be %.3f m from the second axis, which it can be "
                  "%.3f to %.3f m from",
                  nearest, closest, farthest);
    found.unreachable = text;
  }
}

void InverseKinematics::shoulder_and_wrist(const RigidTransform& X_BT, Collector& found) const {
  const RigidTransform motion = X_BT * X_TB_;
  const Vector3d p = motion * wrist_ - shoulder_;
  const double reach = p.norm();
  const Vector3d &h4 = axis_[3], arm = point_[3] - shoulder_, fore = wrist_ - point_[3];
  const double axial = h4.dot(fore) * h4.dot(arm);
  const Vector3d flat_fore = fore - h4 * h4.dot(fore);
  const Roots fourth =
      solve_cosine(arm.dot(flat_fore), arm.dot(h4.cross(flat_fore)),
                   0.5 * (reach * reach - arm.squaredNorm() - fore.squaredNorm()) - axial);
  if (fourth.count == 0 || reach < kMeet) {
    const Vector3d flat_arm = arm - h4 * h4.dot(arm);
    const double lengthwise = h4.dot(arm) + h4.dot(fore);
    const double closest = std::hypot(flat_arm.norm() - flat_fore.norm(), lengthwise);
    const double farthest = std::hypot(flat_arm.norm() + flat_fore.norm(), lengthwise);
    found.out_of_reach = std::max(closest - reach, reach - farthest);
    char text[160];
    std::snprintf(text, sizeof text,
                  "out of reach: the wrist would be %.3f m from the shoulder, which it can be %.3f "
                  "to %.3f m from",
                  reach, closest, farthest);
    found.unreachable = text;
    return;
  }
  const Vector3d direction = p / reach;
  for (int i = 0; i < fourth.count; ++i) {
    Positions q(7);
    q[3] = fourth.angle[static_cast<std::size_t>(i)];
    const Matrix3d R4 = turn(h4, q[3]);
    const Vector3d bent = (arm + R4 * fore).normalized();
    const Matrix3d onto = Eigen::Quaterniond::FromTwoVectors(bent, direction).toRotationMatrix();
    for (int k = 0; k < options_.elbow_angles; ++k) {
      const Matrix3d R_shoulder = turn(direction, 2 * kPi * k / options_.elbow_angles) * onto;
      const ThreeAxes shoulder = decompose(axis_[0], axis_[1], axis_[2], R_shoulder, found.seed[0]);
      const ThreeAxes wrist =
          decompose(axis_[4], axis_[5], axis_[6], (R_shoulder * R4).transpose() * motion.linear(),
                    found.seed[4]);
      found.answer.singular = found.answer.singular || shoulder.singular || wrist.singular;
      for (int s = 0; s < shoulder.count; ++s) {
        for (int m = 0; m < 3; ++m) q[m] = shoulder.ways[static_cast<std::size_t>(s)].angle[m];
        for (int w = 0; w < wrist.count; ++w) {
          for (int m = 0; m < 3; ++m) q[4 + m] = wrist.ways[static_cast<std::size_t>(w)].angle[m];
          found.add(q);
        }
      }
    }
  }
}

void InverseKinematics::numeric(const RigidTransform& X_BT, Collector& found) const {
  const int n = chain_.size();
  const auto clamp = [this, n](Positions& q) {
    for (int i = 0; i < n; ++i) {
      const ChainJoint& joint = chain_.joints()[static_cast<std::size_t>(i)];
      q[i] = std::clamp(q[i], joint.lower, joint.upper);
    }
  };
  const auto error_at = [&](const Positions& q) {
    const RigidTransform X = chain_.forward(q);
    Eigen::Matrix<double, 6, 1> error;
    const Eigen::AngleAxisd rotation(Matrix3d(X_BT.linear() * X.linear().transpose()));
    error << X_BT.translation() - X.translation(), rotation.angle() * rotation.axis();
    return error;
  };
  std::mt19937_64 random(options_.seed);
  const auto uniform = [&random] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  double least = std::numeric_limits<double>::infinity();
  for (int start = 0; start <= options_.restarts; ++start) {
    Positions q = found.seed;
    for (int i = 0; start > 0 && i < n; ++i) {
      const ChainJoint& joint = chain_.joints()[static_cast<std::size_t>(i)];
      const double low = std::isfinite(joint.lower) ? joint.lower : -kPi;
      const double high = std::isfinite(joint.upper) ? joint.upper : kPi;
      q[i] = low + (high - low) * uniform();
    }
    clamp(q);
    Eigen::Matrix<double, 6, 1> error = error_at(q);
    double damping = 1e-2;
    for (int step = 0; step < options_.iterations && damping < 1e8; ++step) {
      if (error.head<3>().norm() <= options_.tolerance &&
          error.tail<3>().norm() <= options_.tolerance) {
        found.add(q);
        return;
      }
      const auto J = chain_.jacobian(q);
      const Eigen::Matrix<double, 6, 6> normal =
          J * J.transpose() + damping * Eigen::Matrix<double, 6, 6>::Identity();
      Positions next = q + J.transpose() * normal.ldlt().solve(error);
      clamp(next);
      const Eigen::Matrix<double, 6, 1> after = error_at(next);
      if (after.squaredNorm() < error.squaredNorm()) {
        q = next;
        error = after;
        damping = std::max(1e-14, damping / 10);
      } else {
        damping *= 4;
      }
    }
    least = std::min(least, error.head<3>().norm());
  }
  found.out_of_reach = least;
  found.failure = InverseFailure::kNotFound;
  char text[160];
  std::snprintf(text, sizeof text,
                "no solution was found from %d starts; the nearest was %.1f mm away",
                options_.restarts + 1, 1e3 * least);
  found.unreachable = text;
}

}  // namespace prehend::robot
