#pragma once

#include <numbers>

namespace prehend::shape {

/// What a symmetry plane is judged by.
enum class VoteKind {
  /// The vote of Bohg et al. (2011), equation (3) of tests/oracles/reference_vote.h, and nothing
  /// else, in its own unit (square pixels and kPublishedDepthUnit).
  kPublished,
  /// What contradicts the view, squared outside the mask; a term for mirrored points that coincide
  /// with seen ones (the paper's case i, which its vote ignores); and two weak priors that decide
  /// where the view says nothing.
  kSupported,
};

/// Knobs of the completion. Time grows with orientations x shifts and with 1/thinning^2.
struct CompletionOptions {
  int orientations = 61;  // of the plane about the starting direction, odd, >= 1
  double max_angle = 0.5 * std::numbers::pi;  // rad: they span +-max_angle, in (0, pi/2]
  int shifts = 41;                            // of the plane along its normal, >= 2
  /// Start from the eigenvector of equation (1), without shifts towards the viewer, instead of the
  /// viewing direction and all axes the footprint suggests.
  bool published_start = false;
  /// Range of the shifts from the cloud's centre, away from the viewer, as a fraction of the seen
  /// cloud's extent along the table. Planes before the centre can only be right when more of the
  /// far side than of the near side was seen, so little of that is searched. Planes that contain
  /// the viewing direction are searched from -max_shift/3 to max_shift/3.
  double min_shift = -0.15;
  double max_shift = 0.75;
  /// Side of the voxels in which one point each votes, as a fraction of the extent, in [0, 0.2]; 0:
  /// every point votes. bench_shape measures what it loses.
  double thinning = 0.02;
  /// Bisect angle and shift round the best planes, below the grid's step, and take the middle of
  /// the shifts that are as good as the best one within 0.02 of its vote.
  bool refine = true;
  /// How many distinct planes to refine and hand back, best first, >= 1.
  int planes = 5;
  /// Let the plane lean by up to this [rad] when that improves its vote by `tilt_gain`; 0: never.
  double max_tilt = 0.17;
  double tilt_gain = 0.05;  // vote, >= 0

  VoteKind vote = VoteKind::kSupported;
  /// Distances are measured in units of this fraction of the extent, so that a vote is a number
  /// without unit, the same for a near and a far, a coarse and a fine camera. > 0.
  double reference_fraction = 0.05;
  double outside_weight = 1;   // of E[(distance to the mask)^2], >= 0
  double in_front_weight = 1;  // of E[depth before the seen surface], >= 0
  /// Depth differences below this are noise of the sensor [m], > 0.
  double depth_tolerance = 0.003;
  double support_weight = 1;         // kSupported, >= 0
  double oblique_weight = 0.1;       // kSupported: of 1 - cos(angle between normal and view), >= 0
  double depth_prior_weight = 0.01;  // kSupported: of |depth / width - 1| when completed, >= 0

  /// Mirror the completed cloud once more at a plane perpendicular to the first, when one exists
  /// whose contradiction stays below `max_second_vote`. One plane leaves the far side of a box
  /// that was seen over its edge open.
  bool second_plane = true;
  double max_second_vote = 0.1;  // >= 0, in the vote's unit
  /// Leave out mirrored points that lie where the camera looked through, beyond the tolerance.
  bool drop_contradicted = true;
  /// Holes of the mask up to this fraction of its area count as seen: stereo leaves some, and what
  /// is mirrored into one contradicts nothing. In [0, 1].
  double fill_holes = 0.05;

  /// A plane is refused ("two heads"), and a fall-back completes the shape, when more than
  /// `max_contradicted` of the mirrored points lie where the camera looked through, or its support
  /// s (symmetry.h) is below `min_support`: much more of what can be judged says no than says yes.
  /// Both in [0, 1]; 1 and 0: never refuse. docs/shape.md tells on what they were learnt.
  double max_contradicted = 0.3;
  double min_support = 0.4;

  /// How many completions by other planes to hand back too, at most, >= 0: of `planes`, those that
  /// face the viewer, are not refused, and vote worse than the winner by `alternative_vote` at
  /// most.
  int alternatives = 0;
  double alternative_vote = 0.1;  // >= 0
  /// Hand back too what the other methods (fallbacks.h) make of it, and what is below as above:
  /// those that put no more of their points where the camera looked through than
  /// `max_contradicted`.
  bool other_methods = false;
};

/// The method as published: equation (3) alone, 7 orientations x 5 shifts about one eigenvector,
/// one plane, every point votes, and every mirrored point is kept. Its hypotheses and votes are
/// those of tests/oracles/reference_vote.h.
CompletionOptions as_published();

/// @throws std::invalid_argument naming the option that is out of range.
void check(const CompletionOptions& options);

}  // namespace prehend::shape
