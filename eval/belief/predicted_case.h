#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "eval/data_sets.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/shape/completed_shape.h"

namespace prehend::eval {

/// What the case's view shows of its object, completed with its alternatives and other methods.
struct PredictedCase {
  shape::CompletedShape shape;
  geometry::Plane support_W;    // what it stands on
  Eigen::Vector3d viewpoint_W;  // m
};

/// A look with a camera that is carried.
struct CarriedView {
  geometry::RigidTransform X_WC;                // where it is
  geometry::RigidTransform X_said;              // where it is said to be
  std::vector<geometry::TriangleMesh> links_W;  // of who carries it
  int look = 0;                                 // which of the case, for the noise
};

/// Renders the case's view, or that of the camera that is carried, finds the object in it and
/// completes it. @throws geometry::InputError where nothing is found.
PredictedCase predict_case(const Case& one, const std::optional<CarriedView>& view = std::nullopt);

}  // namespace prehend::eval
