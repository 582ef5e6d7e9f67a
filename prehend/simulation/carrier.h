#pragma once

#include <optional>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/simulation/scene.h"

namespace prehend::simulation {

/// Where a carrier is to go: its position [m] and yaw [rad], at a speed [m/s]. (Not within Carrier:
/// clang would not have it in an optional there.)
struct CarrierTarget {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double yaw = 0;
  double speed = 0;
  template <class Archive>
  void archive(Archive& archive) {
    archive(position, yaw, speed);
  }
};

/// A way of x, y, z [m] and yaw [rad] from where a carrier stands: velocity t + acceleration t^2 /
/// 2
/// + jerk t^3 / 6.
struct CarrierPath {
  Eigen::Vector4d velocity = Eigen::Vector4d::Zero(), acceleration = Eigen::Vector4d::Zero(),
                  jerk = Eigen::Vector4d::Zero();
  double duration = 0;  // s

  /// By `way`, from `start` to `end` [m/s, rad/s]: the cubic that has these at its ends.
  static CarrierPath between(const Eigen::Vector4d& way, const Eigen::Vector4d& start,
                             const Eigen::Vector4d& end, double duration);
  Eigen::Vector4d way(double t) const {
    return t * (velocity + t / 2 * (acceleration + t / 3 * jerk));
  }
  Eigen::Vector4d velocity_at(double t) const {
    return velocity + t * (acceleration + t / 2 * jerk);
  }
  template <class Archive>
  void archive(Archive& archive) {
    archive(velocity, acceleration, jerk, duration);
  }
};

/// The kinematic carrier: straight lines in x, y, z with yaw in time, trapezoidal speed. Its state
/// is its value: copy to save.
class Carrier {
 public:
  explicit Carrier(const CarrierModel& model);

  /// See World::move_carrier.
  void move(const geometry::RigidTransform& X_WG_target, double speed);
  /// See World::drive_carrier.
  void drive(const Eigen::Vector3d& velocity, double yaw_rate, double h);
  /// See World::guide_carrier.
  void guide(const CarrierPath& path);
  void stop();

  /// Chooses the velocity of the coming step of `h` [s]; the pose stays.
  void begin_step(double h);
  /// Moves the pose by that velocity.
  void end_step(double h);

  // Steps of any length, on the trapezoid itself: position and speed are exact while no step goes
  // beyond time_to_bend(). Not to be mixed with the steps above.
  /// For how long [s] the acceleration now stays the same; infinity at rest. Starts what waits.
  double time_to_bend();
  /// Chooses the acceleration of the coming step; pose_after and velocity_after follow it.
  void begin_exact_step();
  void end_exact_step(double h);

  geometry::RigidTransform pose() const { return model_.gripper_pose(position_, yaw_); }
  /// Where it is `t` [s] after the step's beginning, and how fast then.
  geometry::RigidTransform pose_after(double t) const {
    if (guide_) {
      const Eigen::Vector4d way = guide_->way(t);
      return model_.gripper_pose(position_ + way.head<3>(), yaw_ + way[3]);
    }
    if (ramp_ == 0) return model_.gripper_pose(position_ + t * velocity(), yaw_ + t * yaw_rate());
    const double way = t * (path_speed_ + 0.5 * t * ramp_);
    return model_.gripper_pose(position_ + way * path_direction_, yaw_ + way * path_yaw_);
  }
  Eigen::Vector3d velocity_after(double t) const {
    if (guide_) return guide_->velocity_at(t).head<3>();
    return (path_speed_ + t * ramp_) * path_direction_;
  }
  double yaw_rate_after(double t) const {
    return guide_ ? guide_->velocity_at(t)[3] : (path_speed_ + t * ramp_) * path_yaw_;
  }
  Eigen::Vector3d velocity() const {  // m/s
    return guide_ ? Eigen::Vector3d(guide_->velocity.head<3>()) : path_speed_ * path_direction_;
  }
  double yaw_rate() const {  // rad/s
    return guide_ ? guide_->velocity[3] : path_speed_ * path_yaw_;
  }
  double yaw() const { return yaw_; }  // rad
  bool moving() const {
    return guide_ || path_speed_ != 0 || path_remaining_ > 0 || next_.has_value();
  }
  double remaining() const;  // m

  template <class Archive>
  void archive(Archive& archive) {
    archive(position_, yaw_, path_direction_, path_yaw_, path_remaining_, path_speed_,
            path_max_speed_, path_acceleration_, braking_, goal_, next_, guide_);
  }

 private:
  struct Segment {
    double ramp = 0;      // 1/s^2
    double duration = 0;  // s, infinity at rest
  };
  Segment segment();
  void start(const CarrierTarget& target);
  void arrive();
  void require_within(const Eigen::Vector3d& position) const;
  void run_on(const Eigen::Vector3d& velocity, double yaw_rate);
  void end_guided_step(double h);

  CarrierModel model_;
  Eigen::Vector3d position_;
  double yaw_;
  // The path runs over a parameter from 0 to 1.
  Eigen::Vector3d path_direction_ = Eigen::Vector3d::Zero();  // m per unit of the parameter
  double path_yaw_ = 0;                                       // rad per unit
  double path_remaining_ = 0;                                 // units
  double path_speed_ = 0, path_max_speed_ = 0, path_acceleration_ = 0;
  bool braking_ = false;
  double ramp_ = 0;  // 1/s^2, of the exact step under way
  std::optional<CarrierTarget> goal_;
  std::optional<CarrierTarget> next_;  // begins when the running motion has stopped
  std::optional<CarrierPath> guide_;   // from where it stands now; goes before all else
};

}  // namespace prehend::simulation
