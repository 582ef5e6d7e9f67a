#pragma once

#include <functional>
#include <string>

#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/tracked_xml.h"

namespace prehend::robot::formats {

/// Shapes and masses of a document, into the links of `robot`. Rigid bodies are tied to visual
/// nodes, and those to links.
/// @param length metres of the document's unit
/// @param joint_of the joint of "kmodel/joint0/axis0"; null: there is none
/// @throws geometry::InputError as ColladaShapes
void read_collada_bodies(
    TrackedXml& document, double length,
    const std::function<const JointDescription*(const std::string& axis)>& joint_of,
    RobotDescription& robot);

}  // namespace prehend::robot::formats
