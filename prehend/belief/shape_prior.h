#pragma once

#include "prehend/shape/completed_shape.h"

namespace prehend::belief {

/// How far a predicted surface may be from where it is, before anything was felt: standard
/// deviations. docs/belief.md tells on what they were fitted.
struct ShapePrior {
  // Of each point along its normal [m]; neighbours err alike.
  double seen = 0.0008;
  double predicted = 0.003;
  double assumed = 0.006;
  /// The same, of predicted and assumed points, as a share of the object's extent: adds up.
  double predicted_share = 0.02;
  double assumed_share = 0.06;
  double correlation_length = 0.25;  // of errors of points, share of the extent, > 0
  double detail = 0.3;               // share of their variance that is of details
  double detail_length = 0.06;       // of those, share of the extent, > 0
  // Of a mirrored side, as a whole.
  double plane_shift = 0.1;  // of the plane along its normal, share of the extent
  double plane_turn = 0.12;  // rad, about the support's normal
  double plane_tilt = 0.05;  // rad
  // Of a surface of revolution, as a whole.
  double axis_shift = 0.03;  // share of the extent, in each direction along the support
  double radius = 0.03;      // share of the extent
  // Logs of the shapes' weights before anything was felt, up to a constant.
  double vote_scale = shape::kVoteScale;
  double score_scale = 0.15;  // the same of other methods, beside the best mirror's vote
  double rotation = -5.0;     // beside a mirror with the same vote
  double extrusion = -5.2;
  double convex_hull = -5.1;
  double mirrored_below = 2.1;  // what is mirrored at the level half way up too, as below as above
  double lost = 30;             // taken off, times the share of what was seen that its surface lost
  // Where a contact is thought to be on the shape.
  double aside_share = 0.05;   // of the extent, standard: from the point along the surface, > 0
  double least_aside = 0.004;  // m, the same at least, > 0
  double normal_scale = 6;  // log of the likelihood of a contact whose normal is turned by 90 deg

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

}  // namespace prehend::belief
