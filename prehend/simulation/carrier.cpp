#include "prehend/simulation/carrier.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "prehend/simulation/trapezoid.h"

namespace prehend::simulation {

Carrier::Carrier(const CarrierModel& model)
    : model_(model), position_(model.start), yaw_(model.start_yaw) {}

void Carrier::move(const geometry::RigidTransform& X_WG_target, double speed) {
  if (!(std::isfinite(speed) && speed > 0)) {
    throw std::invalid_argument("carrier speed must be finite and positive");
  }
  const Eigen::Vector3d p = X_WG_target.translation();
  constexpr double kSlack = 1e-9;
  if (!p.allFinite() || (p - model_.minimum).minCoeff() < -kSlack ||
      (model_.maximum - p).minCoeff() < -kSlack) {
    throw std::invalid_argument("carrier target (" + std::to_string(p.x()) + ", " +
                                std::to_string(p.y()) + ", " + std::to_string(p.z()) +
                                ") m is outside the carrier's limits");
  }
  const Eigen::Matrix3d turn =
      X_WG_target.linear() * model_.gripper_pose(Eigen::Vector3d::Zero(), 0).linear().transpose();
  constexpr double kTiltTolerance = 2e-3;  // rad
  if (!turn.allFinite() || turn.col(2).cross(Eigen::Vector3d::UnitZ()).norm() > kTiltTolerance ||
      turn(2, 2) < 0) {
    throw std::invalid_argument(
        "carrier target is turned otherwise than in yaw from the mounting orientation");
  }
  const double target_yaw = std::atan2(turn(1, 0), turn(0, 0));
  const double change = std::remainder(target_yaw - yaw_, 2 * std::numbers::pi);
  next_ = Target{p, yaw_ + change, speed};
  braking_ = path_speed_ != 0;
  if (!braking_) path_remaining_ = 0;
}

// A path without end, at a speed of 1 of it each second.
void Carrier::drive(const Eigen::Vector3d& velocity, double yaw_rate, double h) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kBeyond = 1e-9;  // m
  if (!velocity.allFinite() || !std::isfinite(yaw_rate)) {
    throw std::invalid_argument("the carrier's velocity must be finite");
  }
  const Eigen::Vector3d next = position_ + h * velocity;
  if ((next - model_.minimum).minCoeff() < -kBeyond ||
      (model_.maximum - next).minCoeff() < -kBeyond) {
    throw std::invalid_argument("the carrier would leave its limits");
  }
  next_.reset();
  goal_.reset();
  braking_ = false;
  path_direction_ = velocity;
  path_yaw_ = yaw_rate;
  const double speed = velocity.norm(), rate = std::abs(yaw_rate);
  const bool moves = speed > 0 || rate > 0;
  path_speed_ = path_max_speed_ = moves ? 1 : 0;
  path_remaining_ = moves ? kInfinity : 0;
  path_acceleration_ = std::min(speed > 0 ? model_.max_acceleration / speed : kInfinity,
                                rate > 0 ? model_.max_yaw_acceleration / rate : kInfinity);
  if (!moves) path_acceleration_ = 0;
}

void Carrier::stop() {
  next_.reset();
  braking_ = path_speed_ != 0;
  if (!braking_) path_remaining_ = 0;
}

void Carrier::start(const Target& target) {
  goal_ = target;
  path_direction_ = target.position - position_;
  path_yaw_ = target.yaw - yaw_;
  path_remaining_ = 1;
  const double length = path_direction_.norm(), angle = std::abs(path_yaw_);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  path_max_speed_ =
      std::min(length > 0 ? std::min(target.speed, model_.max_speed) / length : kInfinity,
               angle > 0 ? model_.max_yaw_rate / angle : kInfinity);
  path_acceleration_ = std::min(length > 0 ? model_.max_acceleration / length : kInfinity,
                                angle > 0 ? model_.max_yaw_acceleration / angle : kInfinity);
  if (length < 1e-9 && angle < 1e-9) path_remaining_ = 0;
}

void Carrier::begin_step(double h) {
  if (braking_) {
    path_speed_ = std::max(0.0, path_speed_ - path_acceleration_ * h);
    if (path_speed_ == 0) {
      braking_ = false;
      path_remaining_ = 0;
    }
  }
  if (!braking_ && next_) {
    const Target target = *next_;
    next_.reset();
    start(target);
  }
  if (!braking_ && path_remaining_ > 0) {
    path_speed_ =
        next_trapezoid_speed(path_remaining_, path_speed_, path_max_speed_, path_acceleration_, h);
  }
}

void Carrier::end_step(double h) {
  if (path_speed_ == 0) return;
  position_ += h * velocity();
  yaw_ += h * yaw_rate();
  path_remaining_ = std::max(0.0, path_remaining_ - h * path_speed_);
  if (!braking_ && path_remaining_ < 1e-9 && path_speed_ <= path_acceleration_ * h) arrive();
}

void Carrier::arrive() {
  path_remaining_ = 0;
  path_speed_ = 0;
  position_ = goal_->position;
  yaw_ = goal_->yaw;
}

// Speeds up, goes on or brakes, so that it stands at the goal.
Carrier::Segment Carrier::segment() {
  constexpr double kSame = 1e-9;  // relative
  if (braking_ && path_speed_ == 0) {
    braking_ = false;
    path_remaining_ = 0;
  }
  if (!braking_ && next_) {
    const Target target = *next_;
    next_.reset();
    start(target);
  }
  const double v = path_speed_, A = path_acceleration_, left = path_remaining_;
  if (braking_) return {-A, v / A};
  if (left <= 0) return {0, std::numeric_limits<double>::infinity()};
  const double braking = v * v / (2 * A);
  if (left <= braking * (1 + kSame)) return {-v * v / (2 * left), 2 * left / v};
  if (v >= path_max_speed_ * (1 - kSame)) return {0, (left - braking) / v};
  // To the full speed, or to where braking has to begin: v t + A t^2 / 2 + (v + A t)^2 / (2 A).
  const double to_brake = (std::sqrt(0.5 * v * v + A * left) - v) / A;
  return {A, std::min((path_max_speed_ - v) / A, to_brake)};
}

double Carrier::time_to_bend() { return segment().duration; }

void Carrier::begin_exact_step() { ramp_ = segment().ramp; }

void Carrier::end_exact_step(double h) {
  const double way = h * (path_speed_ + 0.5 * h * ramp_);
  position_ += way * path_direction_;
  yaw_ += way * path_yaw_;
  path_remaining_ = std::max(0.0, path_remaining_ - way);
  path_speed_ = std::clamp(path_speed_ + h * ramp_, 0.0, path_max_speed_);
  // Rounding of a braking's end.
  const bool slow = path_speed_ < 1e-9 * path_max_speed_;
  if (ramp_ < 0 && slow) path_speed_ = 0;
  if (ramp_ < 0 && slow && !braking_) arrive();
  ramp_ = 0;
}

double Carrier::remaining() const {
  if (next_) return (next_->position - position_).norm();
  if (!goal_) return 0;
  return path_remaining_ * path_direction_.norm();
}

}  // namespace prehend::simulation
