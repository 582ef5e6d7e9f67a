#include "prehend/motion/robot_in_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

namespace prehend::motion {

using Eigen::Vector3d;
using geometry::RigidTransform;

namespace {

constexpr double kOwnStep = 0.05;     // rad or m
constexpr double kFirstPiece = 0.15;  // rad or m, of any joint
constexpr float kRoundingUp = 2e-6F;  // m, of bounds in single precision

/// Middles of the pieces that a sweep begins with, as shares of the line; all are of one size.
std::vector<double> first_middles(const Eigen::VectorXd& way) {
  const double longest = way.size() > 0 ? way.maxCoeff() : 0;
  std::vector<double> middles(
      static_cast<std::size_t>(std::max(1, static_cast<int>(std::ceil(longest / kOwnStep)))));
  const double half = 0.5 / static_cast<double>(middles.size());
  for (std::size_t i = 0; i < middles.size(); ++i) {
    middles[i] = (2 * static_cast<double>(i) + 1) * half;
  }
  return middles;
}

}  // namespace

RobotInWorld::RobotInWorld(robot::KinematicChain chain, RobotSpheres spheres, CollisionWorld world,
                           double margin)
    : chain_(std::move(chain)),
      spheres_(std::move(spheres)),
      world_(std::move(world)),
      margin_(margin),
      own_(spheres_.spheres.size()),
      own_pairs_(spheres_.self_pairs.size()),
      own_batch_(std::make_shared<const BatchScene>(make_batch_robot(chain_, spheres_))),
      batch_(*own_batch_) {
  compile();
}

void RobotInWorld::compile() {
  place_in_batch(chain_, world_, margin_, batch_);
  if (shapes_) {
    shapes_ = std::make_shared<const ShapesInWorld>(shapes_->shared_robot(), world_, margin_,
                                                    shapes_.get());
  }
  find_levers();
}

void RobotInWorld::use_checker(std::shared_ptr<const CollisionChecker> checker,
                               const std::vector<RobotShape>& shapes) {
  shapes_.reset();
  if (checker) {
    for (const RobotShape& shape : shapes) {
      if (shape.joint >= -1 && shape.joint < chain_.size()) continue;
      throw std::invalid_argument("RobotInWorld::use_checker: shapes of another robot");
    }
    shapes_ = std::make_shared<const ShapesInWorld>(
        std::make_shared<const CheckedRobot>(std::move(checker), shapes, chain_), world_, margin_,
        nullptr);
  }
  find_levers();
}

void RobotInWorld::find_levers() {
  const auto& joints = chain_.joints();
  levers_ = Eigen::MatrixXd::Zero(chain_.size(), chain_.size());
  // Of what is `length` from the origin after joint `k`: its farthest from each joint's origin, the
  // links between stretched.
  const auto stretch = [&](int k, double length) {
    for (int j = k; j >= 0; --j) {
      const auto i = static_cast<std::size_t>(j);
      double& lever = levers_(k, j);
      lever = std::max(lever, joints[i].is_revolute ? length : 1);
      length += joints[i].X_PJ.translation().norm();
      if (!joints[i].is_revolute) {
        length += std::max(std::abs(joints[i].lower), std::abs(joints[i].upper));
      }
    }
  };
  for (const RobotSphere& ball : spheres_.spheres) stretch(ball.joint, ball.p_J.norm());
  if (!shapes_) return;
  for (const CheckedRobot::Shape& shape : shapes_->robot().shapes()) {
    stretch(shape.joint, CheckedRobot::reach(shape));
  }
}

void RobotInWorld::attach(const std::vector<RobotSphere>& balls_T) {
  hold(balls_T);
  compile();
}

void RobotInWorld::hold(const std::vector<RobotSphere>& balls_T) {
  let_go();
  const int last = chain_.size() - 1;
  for (const RobotSphere& ball : balls_T) {
    const int index = static_cast<int>(spheres_.spheres.size());
    spheres_.spheres.push_back({last, chain_.X_JT() * ball.p_J, ball.radius});
    for (std::size_t other = 0; other < own_; ++other) {
      if (spheres_.spheres[other].joint > last - 2) continue;
      spheres_.self_pairs.emplace_back(static_cast<int>(other), index);
    }
  }
  hold_in_batch(chain_, spheres_, own_pairs_, batch_);
}

void RobotInWorld::let_go() {
  spheres_.spheres.resize(own_);
  spheres_.self_pairs.resize(own_pairs_);
  batch_ = *own_batch_;
}

void RobotInWorld::detach() {
  let_go();
  compile();
}

double RobotInWorld::held_clearance(const std::string& name,
                                    const Eigen::Ref<const Eigen::VectorXd>& q) const {
  std::vector<Vector3d> centers;
  spheres_.centers(chain_, q, centers);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = own_; i < centers.size(); ++i) {
    least = std::min(least, world_.clearance_from(name, centers[i], spheres_.spheres[i].radius));
  }
  return least;
}

RobotInWorld::Touch RobotInWorld::first_touch(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  thread_local std::vector<Vector3d> centers;
  spheres_.centers(chain_, q, centers);
  // Where shapes are tested, what is held alone is balls.
  for (std::size_t i = shapes_ ? own_ : 0; i < centers.size(); ++i) {
    // What stands with the base never moves.
    if (spheres_.spheres[i].joint < 0) continue;
    const RobotSphere& ball = spheres_.spheres[i];
    if (!world_.touches(centers[i], ball.radius, margin_,
                        part_of_ball(ball, i >= own_, chain_.size()))) {
      continue;
    }
    return {static_cast<int>(i), -1, centers[i]};
  }
  for (const auto& [a, b] : std::span(spheres_.self_pairs).subspan(shapes_ ? own_pairs_ : 0)) {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    const double reach = spheres_.spheres[i].radius + spheres_.spheres[j].radius;
    if ((centers[i] - centers[j]).squaredNorm() < reach * reach) return {a, b, centers[i]};
  }
  return {};
}

bool RobotInWorld::is_free(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  if (!chain_.within_limits(q)) return false;
  return shapes_ ? !do_shapes_touch(q, nullptr) : first_touch(q).ball < 0;
}

std::string RobotInWorld::problem(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  if (!chain_.within_limits(q)) return chain_.limit_problem(q);
  const auto link = [this](int joint) -> std::string {
    if (joint < 0) return "the base";
    return "the link of joint '" + chain_.joints()[static_cast<std::size_t>(joint)].name + "'";
  };
  if (shapes_) {
    std::vector<RigidTransform> X_BJ;
    chain_.forward(q, X_BJ);
    const ShapesInWorld::Touch touch = shapes_->first_touch(X_BJ, nullptr);
    if (touch.found && touch.obstacle < 0) {
      return link(touch.joint) + " touches " + link(touch.other_joint);
    }
    if (touch.found) {
      return link(touch.joint) + " touches '" +
             world_.obstacles()[static_cast<std::size_t>(touch.obstacle)].name + "'";
    }
  }
  const Touch touch = first_touch(q);
  if (touch.ball < 0) return {};
  const auto part = [&](int ball) -> std::string {
    if (static_cast<std::size_t>(ball) >= own_) return "what is held";
    return link(spheres_.spheres[static_cast<std::size_t>(ball)].joint);
  };
  if (touch.other >= 0) return part(touch.ball) + " touches " + part(touch.other);
  const auto index = static_cast<std::size_t>(touch.ball);
  const RobotSphere& ball = spheres_.spheres[index];
  std::string touched;
  world_.touches(touch.center, ball.radius, margin_,
                 part_of_ball(ball, index >= own_, chain_.size()), &touched);
  return part(touch.ball) + " touches '" + touched + "'";
}

bool RobotInWorld::is_free_between(const Eigen::Ref<const Eigen::VectorXd>& from,
                                   const Eigen::Ref<const Eigen::VectorXd>& to, double step) const {
  const double way = (to - from).cwiseAbs().maxCoeff();
  const int steps = std::max(1, static_cast<int>(std::ceil(way / step)));
  // Limits are a box: what is between two positions within is within.
  if (!chain_.within_limits(from) || !chain_.within_limits(to)) return false;
  if (shapes_) return are_shapes_free_between(from, to, steps);
  const int batches = (steps + kBatch) / kBatch;  // of steps + 1 positions
  std::array<float, robot::kMostChainJoints * kBatch> q;
  std::array<double, kBatch> shares;
  const auto is_batch_free = [&](int batch) {
    for (std::size_t lane = 0; lane < kBatch; ++lane) {
      shares[lane] =
          std::min(1.0, static_cast<double>(batch + static_cast<int>(lane) * batches) / steps);
    }
    fill_lanes(from, to, shares.data(), kBatch, q.data());
    return touching_lanes(batch_, q.data(), true) == 0;
  };
  if (!is_batch_free(0)) return false;
  // The middles of what is between the tested next: strides that halve.
  int stride = 1;
  while (stride < batches) stride *= 2;
  for (; stride >= 2; stride /= 2) {
    for (int batch = stride / 2; batch < batches; batch += stride) {
      if (!is_batch_free(batch)) return false;
    }
  }
  return true;
}

bool RobotInWorld::is_swept_free(const Eigen::Ref<const Eigen::VectorXd>& from,
                                 const Eigen::Ref<const Eigen::VectorXd>& to) const {
  if (!chain_.within_limits(from) || !chain_.within_limits(to)) return false;
  if (shapes_) return are_shapes_swept_free(from, to);
  std::array<float, robot::kMostChainJoints * kBatch> q;
  std::array<double, kBatch> shares;
  // Quickly first: many are not free.
  for (std::size_t lane = 0; lane < kBatch; ++lane) {
    shares[lane] = static_cast<double>(lane) / (kBatch - 1);
  }
  fill_lanes(from, to, shares.data(), kBatch, q.data());
  if (touching_lanes(batch_, q.data(), true) != 0) return false;
  const robot::Positions way = to - from;
  const double longest = way.size() > 0 ? way.cwiseAbs().maxCoeff() : 0;
  const auto batches = static_cast<std::size_t>(std::ceil(longest / (kFirstPiece * kBatch)));
  // Middles of pieces of one size as shares of the line, and of those of half the size that are not
  // known to be free.
  thread_local std::vector<double> middles, unknown;
  middles.resize(batches * kBatch);
  double half = 0.5 / static_cast<double>(middles.size());
  for (std::size_t i = 0; i < middles.size(); ++i) {
    // Each batch is spread over the whole line.
    const std::size_t piece = i % kBatch * batches + i / kBatch;
    middles[i] = (2 * static_cast<double>(piece) + 1) * half;
  }
  while (!middles.empty()) {
    const SweepBounds bounds = sweep_bounds(half * way);
    unknown.clear();
    for (std::size_t first = 0; first < middles.size(); first += kBatch) {
      const std::size_t count = std::min<std::size_t>(kBatch, middles.size() - first);
      fill_lanes(from, to, middles.data() + first, count, q.data());
      const SweptLanes lanes = swept_lanes(batch_, q.data(), bounds);
      if (lanes.touch != 0) return false;
      for (std::size_t lane = 0; lane < count; ++lane) {
        if (!((lanes.may_touch >> lane) & 1u)) continue;
        unknown.push_back(middles[first + lane]);
      }
    }
    // Few are cut into more parts: a batch costs as much with empty lanes.
    const std::size_t parts =
        std::clamp<std::size_t>(kBatch / std::max<std::size_t>(1, unknown.size()), 2, 4);
    middles.clear();
    half /= static_cast<double>(parts);
    for (const double middle : unknown) {
      for (std::size_t i = 0; i < parts; ++i) {
        middles.push_back(middle +
                          (2 * static_cast<double>(i) + 1 - static_cast<double>(parts)) * half);
      }
    }
  }
  return true;
}

SweepBounds RobotInWorld::sweep_bounds(const robot::Positions& way) const {
  SweepBounds bounds;
  const robot::Positions ways = way.cwiseAbs();
  const double allowed = std::max(margin_, kBallSpare);
  for (int k = 0; k < chain_.size(); ++k) {
    const auto column = static_cast<std::size_t>(k + 1);
    bounds.way[static_cast<std::size_t>(k)] = static_cast<float>(way[k]);
    // Half of the second derivative, from the frame before joint j: joint j, and each after it,
    // turn and stretch what is after the later one of the two.
    double bow = 0, lever_ways = 0;
    for (int j = k; j >= 0; --j) {
      bow += ways[j] * (levers_(k, j) * ways[j] / 2 + lever_ways);
      lever_ways += levers_(k, j) * ways[j];
      bounds.bow[static_cast<std::size_t>(j) * (SweepBounds::kMost + 1) + column] =
          static_cast<float>(bow - kBallSpare) + kRoundingUp;
    }
    bounds.bow_in_world[column] = static_cast<float>(bow - allowed) + kRoundingUp;
  }
  return bounds;
}

bool RobotInWorld::do_shapes_touch(const Eigen::Ref<const Eigen::VectorXd>& q,
                                   const double* swell) const {
  thread_local std::vector<RigidTransform> X_BJ;
  chain_.forward(q, X_BJ);
  if (shapes_->first_touch(X_BJ, swell).found) return true;
  if (own_ == spheres_.spheres.size()) return false;
  if (first_touch(q).ball >= 0) return true;
  if (!swell) return false;
  for (std::size_t i = own_; i < spheres_.spheres.size(); ++i) {
    const RobotSphere& ball = spheres_.spheres[i];
    const auto joint = static_cast<std::size_t>(ball.joint);
    if (world_.touches(X_BJ[joint] * ball.p_J, ball.radius + swell[joint], margin_, Part::kHeld)) {
      return true;
    }
  }
  return false;
}

bool RobotInWorld::are_shapes_free_between(const Eigen::Ref<const Eigen::VectorXd>& from,
                                           const Eigen::Ref<const Eigen::VectorXd>& to,
                                           int steps) const {
  const auto is_step_free = [&](int step) {
    const robot::Positions q = from + (static_cast<double>(step) / steps) * (to - from);
    return !do_shapes_touch(q, nullptr);
  };
  if (!is_step_free(0) || !is_step_free(steps)) return false;
  // The middles of what is between the tested next: strides that halve.
  int stride = 1;
  while (stride < steps) stride *= 2;
  for (; stride >= 2; stride /= 2) {
    for (int step = stride / 2; step < steps; step += stride) {
      if (!is_step_free(step)) return false;
    }
  }
  return true;
}

bool RobotInWorld::are_shapes_swept_free(const Eigen::Ref<const Eigen::VectorXd>& from,
                                         const Eigen::Ref<const Eigen::VectorXd>& to) const {
  const Eigen::VectorXd way = (to - from).cwiseAbs();
  const Eigen::VectorXd sweep = levers_ * way;
  const double allowed = std::max(margin_, kBallSpare);
  std::vector<double> middles = first_middles(way);
  for (double half = 0.5 / static_cast<double>(middles.size()); !middles.empty(); half /= 2) {
    const Eigen::VectorXd swell = (sweep.array() * half - allowed).max(0);
    const bool swells = swell.size() > 0 && swell.maxCoeff() > 0;
    std::vector<double> unknown;
    for (const double middle : middles) {
      const robot::Positions q = from + middle * (to - from);
      if (!do_shapes_touch(q, swell.data())) continue;
      if (!swells || do_shapes_touch(q, nullptr)) return false;
      unknown.push_back(middle - half / 2);
      unknown.push_back(middle + half / 2);
    }
    middles = std::move(unknown);
  }
  return !do_shapes_touch(from, nullptr) && !do_shapes_touch(to, nullptr);
}

void RobotInWorld::fill_lanes(const Eigen::Ref<const Eigen::VectorXd>& from,
                              const Eigen::Ref<const Eigen::VectorXd>& to, const double* shares,
                              std::size_t count, float* q) const {
  for (std::size_t lane = 0; lane < kBatch; ++lane) {
    const double share = shares[std::min(lane, count - 1)];
    for (int j = 0; j < chain_.size(); ++j) {
      q[static_cast<std::size_t>(j) * kBatch + lane] =
          static_cast<float>(from[j] + share * (to[j] - from[j]));
    }
  }
}

std::uint32_t RobotInWorld::not_free(const robot::Positions* q, int count) const {
  if (count < 1 || count > kBatch) {
    throw std::invalid_argument("RobotInWorld::not_free: 1 to 8 positions at once");
  }
  std::uint32_t beyond = 0;
  if (shapes_) {
    for (int i = 0; i < count; ++i) beyond |= is_free(q[i]) ? 0u : 1u << i;
    return beyond;
  }
  std::array<float, robot::kMostChainJoints * kBatch> lanes;
  for (int lane = 0; lane < kBatch; ++lane) {
    const robot::Positions& from = q[std::min(lane, count - 1)];
    if (lane < count && !chain_.within_limits(from)) beyond |= 1u << lane;
    for (int j = 0; j < chain_.size(); ++j) {
      lanes[static_cast<std::size_t>(j * kBatch + lane)] = static_cast<float>(from[j]);
    }
  }
  return (beyond | touching_lanes(batch_, lanes.data(), false)) & ((1u << count) - 1);
}

}  // namespace prehend::motion
