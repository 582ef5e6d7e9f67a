#pragma once

#include <filesystem>
#include <string>

#include "prehend/robot/formats/loss_report.h"
#include "prehend/robot/formats/robot_description.h"

// SRDF (wiki.ros.org/srdf, MoveIt's): what a URDF cannot say, in a file beside it.
namespace prehend::robot::formats {

/// "hand.srdf" of "hand.urdf".
std::filesystem::path srdf_beside(const std::filesystem::path& urdf);

/// Adds to `robot` what the file says: pairs of links that may touch, passive joints, postures, and
/// end effectors as manipulators, from the parent link to itself. What has no place is in `loss`.
/// @throws geometry::InputError with the place for XML that is none, or numbers that are none
void read_srdf(const std::filesystem::path& file, RobotDescription& robot, LossReport& loss);

/// Whether the description has anything that an SRDF says and a URDF does not.
bool needs_srdf(const RobotDescription& robot);

/// Takes all of it away that the SRDF says in full: manipulators with a tool's frame or closing
/// directions stay, for the extension of the URDF.
void take_out_srdf(RobotDescription& robot);

/// The file's text. Of a manipulator it says base, tip and the gripper's joints.
std::string write_srdf(const RobotDescription& robot, LossReport& loss);

}  // namespace prehend::robot::formats
