#pragma once

#include <Eigen/Core>

#include "prehend/shape/completed_shape.h"

namespace prehend::shape {

/// What a view says about a point that was not itself seen.
struct PointEvidence {
  double outside = 0;       // distance of its pixel to the mask, as metres at its depth; 0 within
  double in_front = 0;      // how far it lies before the seen surface, less the tolerance [m]
  double coincident = 0;    // 1 on the seen surface, falling to 0 at the tolerance
  double contradicted = 0;  // 0 agrees or hidden, 1 lies clearly where the camera looked through
};

/// The mask's distance transform and the depth buffer of the seen points: what was seen, to be
/// asked about any point.
class ViewEvidence {
 public:
  /// `depth_tolerance` [m] as in CompletionOptions. O(pixels).
  /// @throws geometry::InputError when the mask is empty or not of the camera's size, a point is
  /// behind the camera, or less than half of the points project into the mask.
  ViewEvidence(const ObjectView& view, double depth_tolerance);

  /// What the view says about p, given in the optical frame C [m]. O(1).
  PointEvidence about(const Eigen::Vector3d& p_C) const;

 private:
  void fill_distance(const geometry::MaskImage& mask);
  void fill_depth(const ObjectView& view);

  geometry::PinholeCamera camera_;
  double depth_tolerance_;
  geometry::Image<float> distance_;  // to the mask [pixels], 0 within
  geometry::Image<float> depth_;     // of the nearest pixel that has any [m]
};

}  // namespace prehend::shape
