#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/belief/shape_prior.h"
#include "prehend/geometry/plane.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/surface/reconstruct.h"
#include "prehend/surface/shape_cloud.h"

namespace prehend::belief {

/// What the weight of a shape rests on before anything was felt.
struct PriorTerms {
  shape::CompletionMethod method = shape::CompletionMethod::kMirror;
  bool mirrored_below = false;  // at the level half way up, too
  double worse = 0;             // its vote or score over the best mirror's vote
  double lost = 0;              // share of the seen points that its surface does not go through
};

/// The log of that weight, up to a constant of all shapes of an object.
double log_prior(const PriorTerms& terms, const ShapePrior& prior);

/// One of the shapes that an object may have, and how it may differ from that.
///
/// Point i of `points`, x_i with the normal n_i, is thought to be at
///
///     x_i + sum_k theta_k motions[k].col(i) + e_i n_i
///
/// with theta_k independent and standard normal, each moving a whole side (a plane of symmetry that
/// is shifted, turned, tilted; an axis), and e a Gaussian process of mean 0 over the surface,
///
///     cov(e_i, e_j) = d_i d_j ((1 - b) k(|x_i - x_j| / l) + b k(|x_i - x_j| / l'))
///                     ((1 + n_i . n_j) / 2)^2,     k(r) = exp(-r^2 / 2),
///
/// b of it details, d_i = deviation[i]: what was seen hardly moves, what was guessed may (C.
/// Rasmussen and C. Williams, "Gaussian Processes for Machine Learning", MIT Press 2006,
/// section 2.7 on explicit basis functions).
struct ShapeHypothesis {
  std::string name;  // "mirror", "rotation", ...
  /// Spread evenly over the surface that was predicted, with what each rests on.
  surface::ShapeCloud points;
  std::vector<float> deviation;           // one per point [m]
  std::vector<Eigen::Matrix3Xf> motions;  // each 3 x points [m]
  std::vector<float> variance;            // one per point, of its displacement along n [m^2]
  double correlation_length = 0;          // l [m]
  double detail_length = 0;               // l' [m]
  double detail = 0;                      // b
  double aside = 0;         // m, standard, along the surface, of a contact from the point it is of
  double normal_scale = 0;  // as ShapePrior
  PriorTerms prior_terms;
  double log_prior = 0;                   // of its weight, up to a constant of all shapes
  std::vector<geometry::Plane> bounds_W;  // as CompletedShape::bounds_W
};

/// Of one completion, `whole` or one of its alternatives, of an object that stands on `table_W`.
/// `whole` knows the best vote, and where nothing can be.
/// @throws geometry::InputError for a shape that gives no surface, as surface::reconstruct().
ShapeHypothesis hypothesis_of(const shape::CompletedShape& shape,
                              const shape::CompletedShape& whole, const geometry::Plane& table_W,
                              const ShapePrior& prior = {},
                              const surface::SurfaceOptions& surface = {});

}  // namespace prehend::belief
