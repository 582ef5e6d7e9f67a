#pragma once

#include <string>

#include "prehend/robot/formats/robot_description.h"

namespace prehend::tools {

/// "revolute", as in files.
std::string kind_word(robot::formats::JointDescription::Kind kind);
/// "-90 to 90°", "0 to 55 mm", "no limit".
std::string limit_words(const robot::formats::JointDescription& joint);
/// "1.2 N m", "0.5 rad/s": with the joint's units; empty: it is not said.
std::string effort_words(const robot::formats::JointDescription& joint);
std::string speed_words(const robot::formats::JointDescription& joint);
/// Damping, friction, spring and break-away, those that there are.
std::string drag_words(const robot::formats::JointDescription& joint);
/// "2 * a + 0.1", or a polynomial's coefficients from the constant on; empty: it follows none.
std::string follows_words(const robot::formats::JointDescription& joint);
/// "0.5 kg, centre at 0 0 20 mm, ..."
std::string inertial_words(const robot::formats::LinkDescription& link);

}  // namespace prehend::tools
