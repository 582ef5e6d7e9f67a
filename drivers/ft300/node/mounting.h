#pragma once

#include <vector>

#include "drivers/ft300/codec/measurement.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::drivers::ft300 {

/// Pose X_GS of the sensor in the gripper's frame from x, y, z [m] and roll, pitch, yaw [rad] about
/// the fixed axes x, y, z. @throws std::invalid_argument unless six finite numbers.
geometry::RigidTransform mounting_from(const std::vector<double>& values);

/// What the sensor feels, in the gripper's frame about its origin: F_G = R F_S,
/// T_G = R T_S + p x F_G. `inverted`: the sensor shows what the gripper exerts on the world.
Measurement in_gripper_frame(const Measurement& measurement_S, const geometry::RigidTransform& X_GS,
                             bool inverted);

}  // namespace prehend::drivers::ft300
