#pragma once

#include <string>
#include <vector>

#include "prehend/robot/formats/collada_text.h"
#include "prehend/robot/formats/robot_description.h"

// OpenRAVE's extras to COLLADA ("COLLADA Robot Extensions", 0.3.6). Links are called link0, link1,
// ..., joints joint0, ..., both of kmodel0, in the description's order. What these have no word for
// is of a technique of profile "prehend" beside.
namespace prehend::robot::formats {

/// `names` as they are written: collada-dom, by which OpenRAVE and ROS read, has a name end at its
/// first space. With underscores, and each as unique as before.
std::vector<std::string> collada_names(const std::vector<std::string>& names);

/// Of the kinematics model: names that are written otherwise (link_info, joint_info), springs and
/// clutches (joint_info), links that may touch and those that are seen and not touched (collision).
void write_model_extras(const RobotDescription& robot, ColladaText& text);
/// Of the articulated system: manipulators, and where sensors and motors are.
void write_system_extras(const RobotDescription& robot, ColladaText& text);
/// The libraries of sensors and motors. A joint's effort, damping and friction are of a motor
/// without a name: OpenRAVE has them nowhere else, and both of its frictions behind the gear.
std::string collada_extra_libraries(const RobotDescription& robot);

}  // namespace prehend::robot::formats
