#pragma once

#include <vector>

#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/learning/said.h"

namespace prehend::robot::learning {

/// Gives each link shapes to touch: of those that the file has for it the ones that are read, else
/// those that are seen. Left out are the points that simulators collide by in place of a surface:
/// shapes of at most 4 mm beside one of a hundred times their volume, which are no part of a finger
/// and get caught in thin walls.
/// @param said gets each choice, and how sure it is
/// @throws geometry::InputError when no moving link has any.
void complete_shapes(formats::RobotDescription& robot, formats::ShapeMeshes& meshes,
                     std::vector<Said>& said);

}  // namespace prehend::robot::learning
