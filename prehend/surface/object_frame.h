#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::surface {

/// X_WF of a frame F that moves with `points_W`: origin in the middle of their bounds along F's
/// axes, z along the normal of `table_W` or, without one, along the direction of least variance, x
/// along that of the greatest variance perpendicular to z; x, and without a table z, point to the
/// side with the greater third moment. The sums run in the order of the points.
geometry::RigidTransform object_frame(const std::vector<Eigen::Vector3f>& points_W,
                                      const std::optional<geometry::Plane>& table_W);

}  // namespace prehend::surface
