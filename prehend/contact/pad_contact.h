#pragma once

#include <Eigen/Core>

#include "prehend/contact/grasp_model.h"
#include "prehend/contact/pad_kernel.h"

/// A pad between a gripper that moves as prescribed, a slide and a free body: where it is in a step
/// and what its response adds to the equations of the body's twist and the slide's velocity.
namespace prehend::contact {

/// Where a pad is over one step. World frame.
struct PadPlacement {
  Eigen::Matrix3d R_WP;            // at the step's start
  Eigen::Vector3d p_WP;            // m
  Eigen::Vector3d carrier_linear;  // m/s, of P's origin by the gripper's motion at the end
  Eigen::Vector3d angular_W;       // rad/s, of the gripper at the end
  Eigen::Vector3d direction_W;     // of the slide

  geometry::RigidTransform X_PW() const;
  /// X_WP at the end of the step of `h` [s], with the slide moving by `slide_velocity` [m/s].
  geometry::RigidTransform X_WP_at_end(const PadMount& mount, const Eigen::Matrix3d& R_WG_end,
                                       double h, double slide_velocity) const;
};

/// The gripper at the step's start is taken where its velocity at the end would have it come from,
/// so that the end, X_WG_end, is exact. `slide_position` [m] is that of the start.
PadPlacement place_pad(const PadMount& mount, const geometry::RigidTransform& X_WG_end,
                       const Eigen::Vector3d& velocity_end, const Eigen::Vector3d& angular_velocity,
                       double slide_position, double h);

/// Twist of a body relative to the pad, in P, about P's origin: for respond() and advance().
/// `velocity` is that of the body's point at p_WB.
Vector6 relative_twist(const PadMount& mount, const PadPlacement& pad, double slide_velocity,
                       const Eigen::Vector3d& velocity, const Eigen::Vector3d& angular_velocity,
                       const Eigen::Vector3d& p_WB);

/// What a response adds to the system matrix * (body's twist at p_WB, slide's velocity) = right:
/// all times h.
struct PadBlocks {
  Matrix6 body_body;
  Vector6 body_right;
  Eigen::Matrix<double, 1, 6> slide_body;  // to be subtracted, and its transpose
  double slide_slide = 0;
  double slide_right = 0;  // to be subtracted
};
PadBlocks pad_blocks(const PadPlacement& pad, const PadResponse& response, double h,
                     const Eigen::Vector3d& p_WB);

/// [v]x: cross_matrix(v) w = v x w.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);

}  // namespace prehend::contact
