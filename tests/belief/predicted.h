#pragma once

#include "prehend/belief/object_belief.h"
#include "prehend/shape/symmetry.h"
#include "prehend/surface/deviation.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::belief {

inline geometry::TriangleMesh box() {
  return shape::standing(geometry::make_box({0.08, 0.06, 0.1}), 0);
}

inline double deviation_of(const geometry::TriangleMesh& mesh,
                           const geometry::TriangleMesh& truth) {
  return surface::mesh_deviation(truth, mesh, {.samples = 4000}).to_second.mean;
}

/// A body on the table z = 0 as one ideal view predicts it, with whatever else it may be.
struct Predicted {
  geometry::TriangleMesh truth_W;
  shape::SyntheticView view;
  shape::CompletedShape shape;

  explicit Predicted(const geometry::TriangleMesh& standing_W, double azimuth = 0)
      : truth_W(standing_W),
        view(shape::synthetic_view(truth_W, {.azimuth = azimuth, .width = 320})) {
    shape::CompletionOptions options;
    options.alternatives = 3;
    options.other_methods = true;
    shape = shape::complete_by_symmetry(view.view(), options);
  }

  ObjectBelief belief(const BeliefOptions& options = {}) const {
    return ObjectBelief(shape, view.table_W, options);
  }
};

/// The same with its far side `depth` [m] further away than it is: the plane was not found well.
inline Predicted too_deep(const geometry::TriangleMesh& standing_W, double depth) {
  Predicted predicted(standing_W);
  predicted.shape.alternatives.clear();
  predicted.shape.other_methods.clear();
  Eigen::Vector3d away = predicted.shape.symmetry.normal_W;
  const Eigen::Vector3d from = predicted.shape.viewpoint_W;
  if (away.dot(predicted.shape.symmetry.point_W - from) < 0) away = -away;
  for (std::size_t i = 0; i < predicted.shape.cloud_W.size(); ++i) {
    const auto origin = predicted.shape.origin[i];
    if (origin == shape::PointOrigin::kMirrored || origin == shape::PointOrigin::kMirroredBoth) {
      predicted.shape.cloud_W.points[i] += (depth * away).cast<float>();
    }
  }
  predicted.shape.symmetry.point_W += 0.5 * depth * away;
  predicted.shape.mirrored_viewpoint_W += depth * away;
  return predicted;
}

}  // namespace prehend::belief
