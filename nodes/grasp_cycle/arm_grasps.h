#pragma once

#include <string>

#include "msgs/grasp.pb.h"
#include "prehend/control/arm_cycle.h"

namespace prehend::nodes {

/// Whether a grasp has a motion of the arm and positions of the hand.
bool is_executable(const msgs::Grasp& grasp);

/// Without rates and limits of the joints, those that the plan moves close, without limits.
/// @pre is_executable(grasp)
/// @throws geometry::InputError for values that do not belong together or are not finite.
control::ArmGrasp from_message(const msgs::Grasp& grasp);

/// "put 0.15 m away", or what else becomes of the object.
std::string destination(const msgs::Grasp& grasp);

}  // namespace prehend::nodes
