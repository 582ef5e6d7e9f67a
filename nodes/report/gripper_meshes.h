#pragma once

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::nodes {

/// Fingers and housing as boxes in gripper frame G, at `opening` [m].
geometry::TriangleMesh gripper_body(const robot::GripperModel& gripper, double opening);
/// The two pads as thin boxes in G.
geometry::TriangleMesh gripper_pads(const robot::GripperModel& gripper, double opening);

}  // namespace prehend::nodes
