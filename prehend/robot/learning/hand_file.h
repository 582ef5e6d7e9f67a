#pragma once

#include <string>

#include "prehend/robot/learning/learned_hand.h"

namespace prehend::robot::learning {

/// "{xyz: [x, y, z], rpy: [roll, pitch, yaw]}", as read_pose() reads it.
std::string pose_text(const geometry::RigidTransform& X);

/// The text of the YAML file (read_hand_model()) of a learned hand, with what is said of it as
/// comments. @param urdf as the file is to name it @param source that it was learned from
std::string hand_yaml(const LearnedHand& learned, const std::string& urdf,
                      const std::string& source);

}  // namespace prehend::robot::learning
