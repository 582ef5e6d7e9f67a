#pragma once

#include <string>

#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/tracked_xml.h"

namespace prehend::robot::formats {

/// The robot of a COLLADA 1.5 document (Khronos' specification, chapters 5 and 10; openrave.org,
/// "Robot extensions for COLLADA"): kinematics, couplings, speeds, masses, shapes and what
/// ColladaExtras reads; without prehend's extension.
/// @param name of a robot whose model has none
/// @throws geometry::InputError with file, line and mend
RobotDescription read_collada(TrackedXml& document, const std::string& name);

}  // namespace prehend::robot::formats
