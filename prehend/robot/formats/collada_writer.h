#pragma once

#include <string>

#include "prehend/robot/formats/loss_report.h"
#include "prehend/robot/formats/robot_description.h"

namespace prehend::robot::formats {

/// The text of a COLLADA 1.5 document (Khronos' specification, release 2) with OpenRAVE's extras
/// ("COLLADA Robot Extensions", version 0.3.6): a kinematics model, its axes' limits and speeds in
/// degrees, formulas in radians, rigid bodies, a scene whose nodes are bound to the axes, motors,
/// sensors, manipulators, pairs of links that may touch. Fixed joints are axes that have no way,
/// as ROS's collada_urdf has them. What is of no such element is in `loss`: closed loops, postures,
/// floating and planar joints (fixed), meshes that are not loaded (TakenMeshes::kEmbedded loads
/// them). It has no date, so that equal robots are equal files.
/// @throws as refuse_deep_links(), for a link that has more than 46 above it
std::string collada_text(const RobotDescription& robot, LossReport& loss);

}  // namespace prehend::robot::formats
