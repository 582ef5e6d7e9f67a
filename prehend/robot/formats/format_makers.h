#pragma once

#include <memory>

#include "prehend/robot/formats/robot_format.h"

namespace prehend::robot::formats {

std::unique_ptr<RobotFormat> collada_format();
std::unique_ptr<RobotFormat> collada_archive_format();
std::unique_ptr<RobotFormat> graspit_format();
std::unique_ptr<RobotFormat> json_format();
std::unique_ptr<RobotFormat> openrave_format();
std::unique_ptr<RobotFormat> sdf_format();
std::unique_ptr<RobotFormat> simox_format();
std::unique_ptr<RobotFormat> urdf_format();
/// Null where MuJoCo is not there.
std::unique_ptr<RobotFormat> mjcf_format();

}  // namespace prehend::robot::formats
