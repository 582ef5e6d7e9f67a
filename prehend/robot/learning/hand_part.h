#pragma once

#include <string>
#include <vector>

#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/learning/said.h"

namespace prehend::robot::learning {

/// The hand of a robot, with all that a simulation needs of it.
struct HandPart {
  formats::RobotDescription robot;  // its first link is the root
  std::string palm;                 // link
  std::vector<Said> said;
};

/// Cuts the hand out of a robot and completes it.
///
/// The palm is the link in which all chains of moving joints meet; where chains of three joints and
/// more lead from there to another such link, these are arms, and that link is the palm. A hand
/// without an arm keeps what the palm is mounted on. Free bodies are left out.
///
/// Completed is: shapes to touch, from what is seen; masses and inertias, of 1000 kg/m^3, where
/// there are none or where the file's would make the link lighter than cork or heavier than gold;
/// efforts of 10 N at the fingertip, speeds of 1 rad/s and 50 mm/s (also where the file's would
/// press more than 1000 N or move faster than 50 rad/s or 5 m/s), limits of a quarter turn; joints
/// that are no hinge and no slide stand still; those without an actuator, where the file names
/// actuators, follow the hinge above. `said` has each, and how sure it is.
/// @param palm the link, by name; empty: it is found
/// @throws geometry::InputError for a robot without moving joints, of several hands (naming their
/// palms), a palm that is not there, or fingers without any shape that is read.
HandPart hand_part(const formats::RobotDescription& robot, const std::string& palm,
                   formats::ShapeMeshes& meshes);

}  // namespace prehend::robot::learning
