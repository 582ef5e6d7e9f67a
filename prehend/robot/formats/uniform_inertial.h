#pragma once

#include <optional>

#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/shape_mesh.h"

namespace prehend::robot::formats {

/// Mass and inertia of a link that fills its shapes evenly, as if of `density` [kg/m^3]: its
/// collision shapes, or those that are seen where it has none. An open surface is filled to its
/// convex hull; shapes that overlap count twice. None: it has no shape that is read.
std::optional<Inertial> uniform_inertial(const LinkDescription& link, ShapeMeshes& meshes,
                                         double density = 1000);

}  // namespace prehend::robot::formats
