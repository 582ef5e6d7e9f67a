#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/simulation/contact_point.h"
#include "prehend/simulation/gripper_drive.h"

namespace prehend::simulation {

/// A body's share of the velocity system.
struct SolverBody {
  bool is_free = true;  // false: stands still, whatever pushes it
  double mass = 0;      // kg
  Eigen::Matrix3d inertia_W = Eigen::Matrix3d::Identity();  // kg m^2, about the centre of mass
  Eigen::Vector3d center = Eigen::Vector3d::Zero();         // m, centre of mass
  Eigen::Vector3d force = Eigen::Vector3d::Zero();          // N, outer
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();         // N m, outer, about the centre of mass
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();       // m/s: before, then after the step
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s: before, then after
};

/// Advances the velocities of all bodies and of the jaws over a step of `h` [s] under linearised
/// contacts, and fills the contacts' forces and bristles. `jaw_velocity` [m/s] is that of the
/// opening before and after. Bodies that touch one another, and the jaws with those that touch
/// them, are one dense symmetric positive definite system each; it is solved twice, and up to six
/// times while the set of pressing contacts or the saturation of the drive still changes.
void solve_contacts(double h, const GripperDrive& drive, std::vector<SolverBody>& bodies,
                    std::vector<ContactPoint>& contacts, double& jaw_velocity);

}  // namespace prehend::simulation
