#pragma once

#include <filesystem>

#include "msgs/sensors.pb.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::convert {

/// What a robot with the gripper of this file (config/robots) says of it; without a file the
/// default gripper. The header is the caller's.
/// @throws geometry::InputError when it cannot be read or is no gripper.
msgs::GripperDescription describe_gripper(const std::filesystem::path& file);

/// @throws geometry::InputError as robot::parse_gripper_model().
robot::GripperModel from_message(const msgs::GripperDescription& message);

}  // namespace prehend::convert
