#pragma once

#include <filesystem>
#include <optional>

#include "msgs/joints.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/robot/command_modes.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::convert {

/// What a robot with the gripper of this file (config/robots) says of it; without a file the
/// default gripper. The header is the caller's.
/// @throws geometry::InputError when it cannot be read or is no gripper.
msgs::GripperDescription describe_gripper(const std::filesystem::path& file);

/// @throws geometry::InputError as robot::parse_gripper_model().
robot::GripperModel from_message(const msgs::GripperDescription& message);

/// None for a mode of another version of the message.
std::optional<robot::GripperMode> from_message(msgs::GripperCommand::Mode mode);
std::optional<robot::JointMode> from_message(msgs::JointCommand::Mode mode);

}  // namespace prehend::convert
