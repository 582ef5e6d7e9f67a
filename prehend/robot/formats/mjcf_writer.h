#pragma once

#include <string>

#include "prehend/robot/formats/loss_report.h"
#include "prehend/robot/formats/robot_description.h"

namespace prehend::robot::formats {

/// The text of an MJCF file (mujoco.readthedocs.io, "XML reference"), as MuJoCo 2.2 and newer
/// compile it. What MJCF cannot say is in `loss`: speeds, clutches, names of fixed joints, limits
/// on one side, planar joints; a root that is not called world is held by that. Efforts become
/// those of motors. @pre meshes are STL or OBJ files. @throws as refuse_deep_links(), for
/// a body that has more than 95 above it; geometry::InputError for more than kMostMjcfBodies
std::string mjcf_text(const RobotDescription& robot, LossReport& loss);

}  // namespace prehend::robot::formats
