#pragma once

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/robot_model.h"

namespace prehend::report {

/// The collision shapes of all links as one mesh in the root link's frame, with joint k at
/// `positions[k]` [rad or m].
/// @throws std::invalid_argument when there is not one position for each joint of the model.
geometry::TriangleMesh robot_mesh(const robot::RobotModel& model,
                                  const Eigen::Ref<const Eigen::VectorXd>& positions);

}  // namespace prehend::report
