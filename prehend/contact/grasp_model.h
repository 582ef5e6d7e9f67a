#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/contact/pad_depths.h"
#include "prehend/contact/pad_layout.h"
#include "prehend/contact/shape.h"
#include "prehend/contact/slide.h"
#include "prehend/contact/texel_law.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::contact {

/// A tactile pad on the gripper. Frame P: see PadLayout. It moves by `direction_G` per unit of its
/// slide's coordinate.
struct PadMount {
  PadLayout layout;
  TexelLaw law;
  geometry::RigidTransform X_GP = geometry::RigidTransform::Identity();  // slide coordinate 0
  int slide = -1;                                                        // -1: fixed on the gripper
  Eigen::Vector3d direction_G = Eigen::Vector3d::Zero();
};

/// The plane z = 0 of the world under the body's support points (a stiff texel each).
struct GroundModel {
  TexelLaw law;
  std::vector<Eigen::Vector3d> points_B;  // m
};

/// One rigid body between the pads of a gripper whose motion is prescribed, over a plane. Frame B
/// has the body's centre of mass as origin. What does not change.
struct GraspModel {
  Eigen::Vector3d gravity{0, 0, -9.81};                   // m/s^2
  double mass = 0.3;                                      // kg
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();  // kg m^2, about B's origin
  Shape shape = Shape::box(Eigen::Vector3d::Constant(0.05));
  bool body_is_fixed = false;
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();  // at the start
  std::vector<PadMount> pads;
  std::vector<SlideModel> slides;  // at most GraspModel::kMostSlides
  std::optional<GroundModel> ground;

  static constexpr int kMostSlides = 6;
};

/// Inertia of a homogeneous box of `size` [m] about its centre [kg m^2].
Eigen::Matrix3d box_inertia(double mass, const Eigen::Vector3d& size);

/// A ground of constants stiff enough to give way by little under `mass` [kg] on `count` points:
/// 1e5 N/m each, damped to 0.5 of critical for a share of the mass.
GroundModel stiff_ground(double mass, double friction, std::vector<Eigen::Vector3d> points_B);

/// The gripper's motion: straight with constant acceleration and constant turning, from `time` on.
struct GripperMotion {
  double time = 0;                                                       // s
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();  // then
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();                    // m/s, of G's origin, then
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();                // m/s^2
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();            // rad/s, world

  geometry::RigidTransform pose_at(double t) const;
  Eigen::Vector3d velocity_at(double t) const { return velocity + (t - time) * acceleration; }
};

/// Checks every value. @throws std::invalid_argument naming the field: a mass or inertia that is
/// not finite and positive, a slide that is not there, bad constants of a law, ...
void validate(const GraspModel& model);

}  // namespace prehend::contact
