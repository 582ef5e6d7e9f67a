#include "prehend/simulation/carrier.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "prehend/simulation/trapezoid.h"

namespace prehend::simulation {
namespace {

constexpr double kInstant = 1e-9;  // s, shorter than that is nothing

}  // namespace

CarrierPath CarrierPath::between(const Eigen::Vector4d& way, const Eigen::Vector4d& start,
                                 const Eigen::Vector4d& end, double duration) {
  CarrierPath path;
  path.duration = duration;
  path.velocity = start;
  const Eigen::Vector4d rest = way - duration * start, gain = duration * (end - start);
  path.acceleration = (6 * rest - 2 * gain) / (duration * duration);
  path.jerk = (6 * gain - 12 * rest) / (duration * duration * duration);
  return path;
}

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
  if (guide_) run_on(velocity(), yaw_rate());
  next_ = CarrierTarget{p, yaw_ + change, speed};
  braking_ = path_speed_ != 0;
  if (!braking_) path_remaining_ = 0;
}

void Carrier::drive(const Eigen::Vector3d& velocity, double yaw_rate, double h) {
  if (!velocity.allFinite() || !std::isfinite(yaw_rate)) {
    throw std::invalid_argument("the carrier's velocity must be finite");
  }
  require_within(position_ + h * velocity);
  run_on(velocity, yaw_rate);
}

void Carrier::guide(const CarrierPath& path) {
  if (!path.velocity.allFinite() || !path.acceleration.allFinite() || !path.jerk.allFinite() ||
      !(std::isfinite(path.duration) && path.duration > 0)) {
    throw std::invalid_argument("the carrier's path must be finite, its duration positive");
  }
  require_within(position_ + path.way(path.duration).head<3>());
  run_on(Eigen::Vector3d::Zero(), 0);
  guide_ = path;
}

void Carrier::require_within(const Eigen::Vector3d& position) const {
  constexpr double kBeyond = 1e-9;  // m
  if ((position - model_.minimum).minCoeff() < -kBeyond ||
      (model_.maximum - position).minCoeff() < -kBeyond) {
    throw std::invalid_argument("the carrier would leave its limits");
  }
}

// A path without end, at a speed of 1 of it each second.
void Carrier::run_on(const Eigen::Vector3d& velocity, double yaw_rate) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  guide_.reset();
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
  if (guide_) run_on(velocity(), yaw_rate());
  next_.reset();
  braking_ = path_speed_ != 0;
  if (!braking_) path_remaining_ = 0;
}

void Carrier::start(const CarrierTarget& target) {
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

void Carrier::end_guided_step(double h) {
  const Eigen::Vector4d way = guide_->way(h);
  position_ += way.head<3>();
  yaw_ += way[3];
  guide_->velocity = guide_->velocity_at(h);
  guide_->acceleration += h * guide_->jerk;
  guide_->duration -= h;
  if (guide_->duration < kInstant) run_on(velocity(), yaw_rate());
}

void Carrier::begin_step(double h) {
  if (guide_) return;
  if (braking_) {
    path_speed_ = std::max(0.0, path_speed_ - path_acceleration_ * h);
    if (path_speed_ == 0) {
      braking_ = false;
      path_remaining_ = 0;
    }
  }
  if (!braking_ && next_) {
    const CarrierTarget target = *next_;
    next_.reset();
    start(target);
  }
  if (!braking_ && path_remaining_ > 0) {
    path_speed_ =
        next_trapezoid_speed(path_remaining_, path_speed_, path_max_speed_, path_acceleration_, h);
  }
}

void Carrier::end_step(double h) {
  if (guide_) return end_guided_step(h);
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
  if (guide_) return {0, guide_->duration};
  constexpr double kSame = 1e-9;  // relative
  if (braking_ && path_speed_ == 0) {
    braking_ = false;
    path_remaining_ = 0;
  }
  if (!braking_ && next_) {
    const CarrierTarget target = *next_;
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
  if (guide_) return end_guided_step(h);
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
