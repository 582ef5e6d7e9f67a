#pragma once

#include <optional>

#include "prehend/robot/formats/robot_description.h"

// What a file's text says but for rounding is as the robot has it, and so not in prehend's
// extension: `plain`, which was read of it, gets the robot's own numbers where they are near.
namespace prehend::robot::formats {

void take_rounded(Shape& plain, const Shape& robot);
void take_rounded(std::optional<Inertial>& plain, const std::optional<Inertial>& robot);
void take_rounded(JointDescription& plain, const JointDescription& robot);
void take_rounded(Loop& plain, const Loop& robot);
void take_rounded(Sensor& plain, const Sensor& robot);
void take_rounded(Actuator&, const Actuator&);
void take_rounded(Manipulator& plain, const Manipulator& robot);
void take_rounded(Posture&, const Posture&);

}  // namespace prehend::robot::formats
