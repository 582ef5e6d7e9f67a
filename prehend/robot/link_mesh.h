#pragma once

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/robot_model.h"

namespace prehend::robot {

/// A link's collision shapes as one mesh in the link's frame; empty for a link without any.
geometry::TriangleMesh link_mesh(const Link& link);

}  // namespace prehend::robot
