#include "prehend/robot/inverse_kinematics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "prehend/geometry/rotation_between.h"
#include "prehend/geometry/symmetric_solve.h"
#include "prehend/robot/inverse_collector.h"

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
  where = geometry::symmetric_solve<3>(sum, right);
  for (int i = 0; i < 3; ++i) {
    if ((where - points[i]).cross(axes[i]).norm() > kMeet) return false;
  }
  return true;
}

BranchArm::Vector numbers(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Lanes with solutions, nearest to the seed first.
struct Order {
  int count = 0;
  std::array<std::size_t, kBranches> lane{};

  explicit Order(const BranchOutput& output) {
    for (std::size_t i = 0; i < kBranches; ++i) {
      if (!((output.within >> i) & 1u)) continue;
      auto to = static_cast<std::size_t>(count++);
      for (; to > 0 && output.distance[i] < output.distance[lane[to - 1]]; --to) {
        lane[to] = lane[to - 1];
      }
      lane[to] = i;
    }
  }
  Positions positions(const BranchOutput& output, int i) const {
    Positions q(6);
    for (std::size_t j = 0; j < 6; ++j) {
      q[static_cast<Eigen::Index>(j)] = output.q[j][lane[static_cast<std::size_t>(i)]];
    }
    return q;
  }
};

}  // namespace

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
  if (has_three_slides()) return InverseMethod::kThreeSlides;
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
  if (!fits) return InverseMethod::kNumeric;
  for (std::size_t i = 0; i < 6; ++i) {
    branch_arm_.axis[i] = numbers(axis_[i]);
    branch_arm_.low[i] = chain_.joints()[i].lower;
    branch_arm_.high[i] = chain_.joints()[i].upper;
  }
  const auto across = [this](const Vector3d& v) { return v - axis_[1] * axis_[1].dot(v); };
  branch_arm_.point0 = numbers(point_[0]);
  branch_arm_.point1 = numbers(point_[1]);
  branch_arm_.wrist = numbers(wrist_);
  branch_arm_.upper = numbers(across(point_[2] - point_[1]));
  branch_arm_.lower = numbers(across(wrist_ - point_[2]));
  return InverseMethod::kSphericalWrist;
}

void InverseKinematics::check(const RigidTransform& X_BT,
                              const Eigen::Ref<const Eigen::VectorXd>& seed) const {
  if (seed.size() != chain_.size()) {
    throw std::invalid_argument("InverseKinematics::solve: the seed needs " +
                                std::to_string(chain_.size()) + " positions");
  }
  if (!X_BT.matrix().allFinite() || !seed.allFinite()) {
    throw std::invalid_argument("InverseKinematics::solve: pose and seed must be finite");
  }
}

void InverseKinematics::find(const RigidTransform& X_BT, Collector& found) const {
  switch (method_) {
    case InverseMethod::kSphericalWrist:
      found.answer.solutions.reserve(8);
      spherical_wrist(X_BT, found);
      break;
    case InverseMethod::kSphericalShoulderAndWrist:
      shoulder_and_wrist(X_BT, found);
      break;
    case InverseMethod::kThreeSlides:
      three_slides(X_BT, found);
      break;
    case InverseMethod::kNumeric:
      numeric(X_BT, found);
      break;
  }
}

InverseAnswer InverseKinematics::solve(const RigidTransform& X_BT,
                                       const Eigen::Ref<const Eigen::VectorXd>& seed) const {
  check(X_BT, seed);
  BranchOutput output;
  if (solve_in_step(X_BT, seed, output)) {
    const Order order(output);
    InverseAnswer answer;
    answer.solutions.reserve(static_cast<std::size_t>(order.count));
    for (int i = 0; i < order.count; ++i) answer.solutions.push_back(order.positions(output, i));
    return answer;
  }
  Collector found{chain_, seed};
  find(X_BT, found);
  return found.finish();
}

void InverseKinematics::solve_batch(std::span<const RigidTransform> X_BT,
                                    const Eigen::Ref<const Eigen::VectorXd>& seed,
                                    std::vector<InverseSolutions>& answers) const {
  answers.resize(X_BT.size());
  BranchOutput output;
  for (std::size_t i = 0; i < X_BT.size(); ++i) {
    check(X_BT[i], seed);
    InverseSolutions& answer = answers[i];
    answer.failure = InverseFailure::kNone;
    answer.miss = 0;
    answer.singular = false;
    if (solve_in_step(X_BT[i], seed, output)) {
      const Order order(output);
      answer.count = order.count;
      for (int k = 0; k < order.count; ++k) {
        answer.q[static_cast<std::size_t>(k)] = order.positions(output, k);
      }
      continue;
    }
    Collector found{chain_, seed};
    found.in_words = false;
    find(X_BT[i], found);
    const InverseAnswer slow = found.finish();
    answer.count = std::min(InverseSolutions::kMost, static_cast<int>(slow.solutions.size()));
    std::copy_n(slow.solutions.begin(), answer.count, answer.q.begin());
    answer.failure = slow.failure;
    answer.miss = slow.miss;
    answer.singular = slow.singular;
  }
}

bool InverseKinematics::solve_in_step(const RigidTransform& X_BT,
                                      const Eigen::Ref<const Eigen::VectorXd>& seed,
                                      BranchOutput& output) const {
  if (method_ != InverseMethod::kSphericalWrist || !options_.vectorized) return false;
  const RigidTransform motion = X_BT * X_TB_;
  BranchInput input;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      input.R[static_cast<std::size_t>(3 * row + column)] = motion(row, column);
    }
    input.t[static_cast<std::size_t>(row)] = motion(row, 3);
  }
  std::copy_n(seed.data(), 6, input.seed.begin());
  solve_branches(branch_arm_, input, output);
  return !output.is_doubtful && output.within != 0;
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
    if (!found.in_words) return;
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
    const Matrix3d onto = geometry::rotation_between(bent, direction).toRotationMatrix();
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

}  // namespace prehend::robot
