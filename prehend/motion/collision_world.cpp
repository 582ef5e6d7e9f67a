#include "prehend/motion/collision_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "prehend/motion/batch_kernel.h"
#include "prehend/motion/convex_faces.h"

namespace prehend::motion {

using Eigen::Vector3d;
using geometry::RigidTransform;

namespace {

constexpr double kLeastSweep = 1e-3;  // m
constexpr double kOwnStep = 0.05;     // rad or m

}  // namespace

void CollisionWorld::add_plane(const std::string& name, const geometry::Plane& plane_B) {
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.radius = std::numeric_limits<double>::infinity();
  obstacle.faces = {plane_B};
  obstacles_.push_back(std::move(obstacle));
}

void CollisionWorld::add_box(const std::string& name, const RigidTransform& X_BO,
                             const Vector3d& size) {
  if (!(size.minCoeff() > 0) || !size.allFinite() || !X_BO.matrix().allFinite()) {
    throw std::invalid_argument("CollisionWorld: box '" + name + "' needs positive, finite sides");
  }
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.kind = Obstacle::Kind::kBox;
  obstacle.X_OB = X_BO.inverse();
  obstacle.half = size / 2;
  obstacle.center = X_BO.translation();
  obstacle.radius = size.norm() / 2;
  obstacles_.push_back(std::move(obstacle));
}

void CollisionWorld::add_sphere(const std::string& name, const Vector3d& center_B, double radius) {
  if (!(radius > 0) || !std::isfinite(radius) || !center_B.allFinite()) {
    throw std::invalid_argument("CollisionWorld: sphere '" + name + "' needs a positive radius");
  }
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.kind = Obstacle::Kind::kSphere;
  obstacle.center = center_B;
  obstacle.radius = radius;
  obstacles_.push_back(std::move(obstacle));
}

void CollisionWorld::add_convex(const std::string& name, const geometry::TriangleMesh& mesh_B) {
  ConvexFaces convex = convex_faces(name, mesh_B);
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.kind = Obstacle::Kind::kConvex;
  obstacle.center = convex.bounds.center();
  obstacle.radius = convex.radius;
  obstacle.faces = std::move(convex.faces);
  obstacles_.push_back(std::move(obstacle));
}

bool CollisionWorld::remove(const std::string& name) {
  return std::erase_if(obstacles_, [&](const Obstacle& o) { return o.name == name; }) > 0;
}

double CollisionWorld::distance(const Obstacle& obstacle, const Vector3d& p_B, double enough) {
  switch (obstacle.kind) {
    case Obstacle::Kind::kSphere:
      return (p_B - obstacle.center).norm() - obstacle.radius;
    case Obstacle::Kind::kBox: {
      const Vector3d beyond = (obstacle.X_OB * p_B).cwiseAbs() - obstacle.half;
      return beyond.cwiseMax(0).norm() + std::min(0.0, beyond.maxCoeff());
    }
    default: {
      double most = -std::numeric_limits<double>::infinity();
      for (const geometry::Plane& face : obstacle.faces) {
        most = std::max(most, face.signed_distance(p_B));
        if (most >= enough) break;
      }
      return most;
    }
  }
}

double CollisionWorld::clearance(const Vector3d& center_B, double radius,
                                 std::string* nearest) const {
  double least = kInfinity;
  for (const Obstacle& obstacle : obstacles_) {
    const double gap = distance(obstacle, center_B, least + radius) - radius;
    if (gap >= least) continue;
    least = gap;
    if (nearest) *nearest = obstacle.name;
  }
  return least;
}

bool CollisionWorld::set_margin(const std::string& name, Part part, double margin) {
  if (std::isnan(margin)) throw std::invalid_argument("CollisionWorld: a margin is not a number");
  bool found = false;
  for (Obstacle& obstacle : obstacles_) {
    if (obstacle.name != name) continue;
    obstacle.margin[static_cast<std::size_t>(part)] = margin;
    found = true;
  }
  return found;
}

bool CollisionWorld::touches(const Vector3d& center_B, double radius, double margin, Part part,
                             std::string* touched) const {
  double deepest = 0;
  for (const Obstacle& obstacle : obstacles_) {
    const double reach = radius + obstacle.margin_for(part, margin);
    const double far = obstacle.radius + reach;
    if (!(far > 0) || (center_B - obstacle.center).squaredNorm() > far * far) continue;
    const double depth = reach - distance(obstacle, center_B, reach - deepest);
    if (!(depth > deepest)) continue;
    if (!touched) return true;
    deepest = depth;
    *touched = obstacle.name;
  }
  return deepest > 0;
}

std::vector<std::string> CollisionWorld::names() const {
  std::vector<std::string> names;
  for (const Obstacle& obstacle : obstacles_) {
    if (std::find(names.begin(), names.end(), obstacle.name) == names.end()) {
      names.push_back(obstacle.name);
    }
  }
  return names;
}

double CollisionWorld::clearance_from(const std::string& name, const Vector3d& center_B,
                                      double radius) const {
  double least = kInfinity;
  for (const Obstacle& obstacle : obstacles_) {
    if (obstacle.name != name) continue;
    // Of what is farther than the nearest so far, not even the faces are asked.
    const double far = obstacle.radius + radius + least;
    if (far > 0 && (center_B - obstacle.center).squaredNorm() >= far * far) continue;
    least = std::min(least, distance(obstacle, center_B, least + radius) - radius);
  }
  return least;
}

Part part_of_ball(const RobotSphere& ball, bool is_held, int joints) {
  if (is_held) return Part::kHeld;
  return ball.joint == joints - 1 ? Part::kHand : Part::kArm;
}

RobotInWorld::RobotInWorld(robot::KinematicChain chain, RobotSpheres spheres, CollisionWorld world,
                           double margin)
    : chain_(std::move(chain)),
      spheres_(std::move(spheres)),
      world_(std::move(world)),
      margin_(margin),
      own_(spheres_.spheres.size()),
      own_pairs_(spheres_.self_pairs.size()) {
  compile();
}

void RobotInWorld::compile() {
  batch_ = make_batch_scene(chain_, spheres_, own_, world_, margin_);
  find_levers();
}

void RobotInWorld::find_levers() {
  const auto& joints = chain_.joints();
  levers_ = Eigen::MatrixXd::Zero(chain_.size(), chain_.size());
  for (const RobotSphere& ball : spheres_.spheres) {
    // Its farthest from each joint's origin: the links between, stretched.
    double length = ball.p_J.norm();
    for (int j = ball.joint; j >= 0; --j) {
      const auto i = static_cast<std::size_t>(j);
      double& lever = levers_(ball.joint, j);
      lever = std::max(lever, joints[i].is_revolute ? length : 1);
      length += joints[i].X_PJ.translation().norm();
      if (!joints[i].is_revolute) {
        length += std::max(std::abs(joints[i].lower), std::abs(joints[i].upper));
      }
    }
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
}

void RobotInWorld::let_go() {
  spheres_.spheres.resize(own_);
  spheres_.self_pairs.resize(own_pairs_);
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
  for (std::size_t i = 0; i < centers.size(); ++i) {
    // What stands with the base never moves.
    if (spheres_.spheres[i].joint < 0) continue;
    const RobotSphere& ball = spheres_.spheres[i];
    if (!world_.touches(centers[i], ball.radius, margin_,
                        part_of_ball(ball, i >= own_, chain_.size()))) {
      continue;
    }
    return {static_cast<int>(i), -1, centers[i]};
  }
  for (const auto& [a, b] : spheres_.self_pairs) {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    const double reach = spheres_.spheres[i].radius + spheres_.spheres[j].radius;
    if ((centers[i] - centers[j]).squaredNorm() < reach * reach) return {a, b, centers[i]};
  }
  return {};
}

bool RobotInWorld::is_free(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  return chain_.within_limits(q) && first_touch(q).ball < 0;
}

std::string RobotInWorld::problem(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  if (!chain_.within_limits(q)) return chain_.limit_problem(q);
  const Touch touch = first_touch(q);
  if (touch.ball < 0) return {};
  const auto part = [this](int ball) -> std::string {
    if (static_cast<std::size_t>(ball) >= own_) return "what is held";
    const int joint = spheres_.spheres[static_cast<std::size_t>(ball)].joint;
    if (joint < 0) return "the base";
    return "the link of joint '" + chain_.joints()[static_cast<std::size_t>(joint)].name + "'";
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
  const Eigen::VectorXd way = (to - from).cwiseAbs();
  const double longest = way.size() > 0 ? way.maxCoeff() : 0;
  // Middles of pieces, as shares of the line; all pieces are of one size.
  std::vector<double> middles(
      static_cast<std::size_t>(std::max(1, static_cast<int>(std::ceil(longest / kOwnStep)))));
  double half = 0.5 / static_cast<double>(middles.size());
  for (std::size_t i = 0; i < middles.size(); ++i)
    middles[i] = (2 * static_cast<double>(i) + 1) * half;
  const Eigen::VectorXd sweep = levers_ * way;  // m, of the balls of each joint on the whole line
  const double allowed = std::max(margin_, kLeastSweep);
  std::array<float, robot::kMostChainJoints * kBatch> q;
  std::array<float, robot::kMostChainJoints> swell{};
  for (; !middles.empty(); half /= 2) {
    bool swells = false;
    for (int k = 0; k < chain_.size(); ++k) {
      const double more = std::max(0.0, sweep[k] * half - allowed);
      swell[static_cast<std::size_t>(k)] = static_cast<float>(more * (1 + 1e-6));
      swells = swells || more > 0;
    }
    std::vector<double> unknown;
    for (std::size_t first = 0; first < middles.size(); first += kBatch) {
      const std::size_t count = std::min<std::size_t>(kBatch, middles.size() - first);
      fill_lanes(from, to, middles.data() + first, count, q.data());
      std::uint32_t mask = touching_lanes(batch_, q.data(), !swells, swell.data());
      if (mask != 0 && !swells) return false;
      for (std::size_t lane = 0; lane < count; ++lane) {
        if (!((mask >> lane) & 1u)) continue;
        unknown.push_back(middles[first + lane] - half / 2);
        unknown.push_back(middles[first + lane] + half / 2);
      }
    }
    middles = std::move(unknown);
  }
  const std::array<double, 2> ends{0, 1};
  fill_lanes(from, to, ends.data(), ends.size(), q.data());
  return touching_lanes(batch_, q.data(), true) == 0;
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
  std::array<float, robot::kMostChainJoints * kBatch> lanes;
  std::uint32_t beyond = 0;
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
