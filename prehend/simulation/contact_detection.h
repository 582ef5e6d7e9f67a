#pragma once

#include <array>
#include <vector>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/simulation/contact_point.h"
#include "prehend/simulation/rigid_body.h"

namespace prehend::simulation {

/// Where the gripper is and how its carrier moves.
struct GripperPlacement {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s, of G's origin in the world
  double yaw_rate = 0;                                 // rad/s, about the world's z
  double opening = 0;                                  // m

  /// Velocity of a gripper-fixed point [m/s], without the jaws' motion.
  Eigen::Vector3d velocity_at(const Eigen::Vector3d& p_W) const {
    return velocity + yaw_rate * Eigen::Vector3d::UnitZ().cross(p_W - X_WG.translation());
  }
};

/// A box of the gripper. `side` is +1 for what moves with the left finger, -1 with the right one, 0
/// for the housing.
struct GripperBox {
  Eigen::AlignedBox3d box_G;  // m
  double side = 0;
  ContactPartner partner = kHousing;
};
/// Both fingers behind their pads' foam, and the housing.
std::array<GripperBox, 3> gripper_boxes(const robot::GripperModel& model, double opening);
/// The foam of both pads.
std::array<GripperBox, 2> pad_boxes(const robot::GripperModel& model, double opening);

/// Points of body `index` that touch the table z = 0 or are nearer to it than they can come within
/// `h` [s] at their present speed.
void detect_table(const BodyModel& model, const BodyState& state, int index, double h,
                  std::vector<ContactPoint>& contacts);

/// Whether the body's bounds come as near to the gripper's as `margin` [m].
bool near_gripper(const BodyModel& model, const BodyState& state,
                  const robot::GripperModel& gripper, const GripperPlacement& placement,
                  double margin);

/// Touching points of body `index` with fingers and housing, and with the pads as if they were
/// stiff when `rigid_pads`.
void detect_gripper(const BodyModel& model, const BodyState& state, int index,
                    const robot::GripperModel& gripper, const GripperPlacement& placement,
                    bool rigid_pads, std::vector<ContactPoint>& contacts);

/// Touching points of bodies `a` and `b`: surface points of each inside the other. Costs one box
/// test when far, none of that either with `check_bounds` false (for the rule's twin test).
void detect_bodies(const BodyModel& model_a, const BodyState& state_a, int a,
                   const BodyModel& model_b, const BodyState& state_b, int b, bool check_bounds,
                   std::vector<ContactPoint>& contacts);

/// Bounds in frame F of a box given in frame B.
Eigen::AlignedBox3d transformed_box(const geometry::RigidTransform& X_FB,
                                    const Eigen::AlignedBox3d& box_B);

}  // namespace prehend::simulation
