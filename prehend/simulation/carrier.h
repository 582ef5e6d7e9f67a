#pragma once

#include <optional>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/simulation/scene.h"

namespace prehend::simulation {

/// The kinematic carrier: straight lines in x, y, z with yaw in time, trapezoidal speed. Its state
/// is its value: copy to save.
class Carrier {
 public:
  explicit Carrier(const CarrierModel& model);

  /// See World::move_carrier.
  void move(const geometry::RigidTransform& X_WG_target, double speed);
  void stop();

  /// Chooses the velocity of the coming step of `h` [s]; the pose stays.
  void begin_step(double h);
  /// Moves the pose by that velocity.
  void end_step(double h);

  geometry::RigidTransform pose() const { return model_.gripper_pose(position_, yaw_); }
  /// Where it is `t` [s] after the step's beginning.
  geometry::RigidTransform pose_after(double t) const {
    return model_.gripper_pose(position_ + t * velocity(), yaw_ + t * yaw_rate());
  }
  Eigen::Vector3d velocity() const { return path_speed_ * path_direction_; }  // m/s
  double yaw_rate() const { return path_speed_ * path_yaw_; }                 // rad/s
  bool moving() const { return path_speed_ != 0 || path_remaining_ > 0 || next_.has_value(); }
  double remaining() const;  // m

  template <class Archive>
  void archive(Archive& archive) {
    archive(position_, yaw_, path_direction_, path_yaw_, path_remaining_, path_speed_,
            path_max_speed_, path_acceleration_, braking_, goal_, next_);
  }

 private:
  struct Target {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    double yaw = 0;
    double speed = 0;
    template <class Archive>
    void archive(Archive& archive) {
      archive(position, yaw, speed);
    }
  };
  void start(const Target& target);

  CarrierModel model_;
  Eigen::Vector3d position_;
  double yaw_;
  // The path runs over a parameter from 0 to 1.
  Eigen::Vector3d path_direction_ = Eigen::Vector3d::Zero();  // m per unit of the parameter
  double path_yaw_ = 0;                                       // rad per unit
  double path_remaining_ = 0;                                 // units
  double path_speed_ = 0, path_max_speed_ = 0, path_acceleration_ = 0;
  bool braking_ = false;
  std::optional<Target> goal_;
  std::optional<Target> next_;  // begins when the running motion has stopped
};

}  // namespace prehend::simulation
