#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/rigid_transform.h"

// Texts of XML files, so exact that what is read of them is what was written.
namespace prehend::robot::formats {

/// With <, >, &, quotes and ends of lines as entities.
std::string escaped(const std::string& text);
/// Of what is no attribute: quotes stay, so that it is read with ease.
std::string escaped_text(const std::string& text);
/// The shortest text that reads as the same number.
std::string number_text(double number);
std::string numbers_text(const Eigen::Vector3d& numbers);
/// Roll, pitch, yaw [rad] of Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& rotation);
geometry::RigidTransform from_roll_pitch_yaw(const Eigen::Vector3d& place,
                                             const Eigen::Vector3d& angles);
/// "x y z roll pitch yaw"
std::string pose_text(const geometry::RigidTransform& X);

}  // namespace prehend::robot::formats
