#pragma once

#include <Eigen/Core>

#include "eval/data_sets.h"
#include "prehend/geometry/plane.h"
#include "prehend/shape/completed_shape.h"

namespace prehend::eval {

/// What the case's view shows of its object, completed with its alternatives and other methods.
struct PredictedCase {
  shape::CompletedShape shape;
  geometry::Plane support_W;    // what it stands on
  Eigen::Vector3d viewpoint_W;  // m
};

/// Renders the view, finds the object in it and completes it. @throws geometry::InputError where
/// nothing is found.
PredictedCase predict_case(const Case& one);

}  // namespace prehend::eval
