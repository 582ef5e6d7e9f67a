#pragma once

#include "prehend/shape/completed_shape.h"

namespace prehend::shape {

/// What a symmetry plane is judged by.
enum class VoteKind {
  /// The vote of Bohg et al. (2011) alone: only what contradicts the view counts.
  kContradiction,
  /// kContradiction plus a term for mirrored points that coincide with seen ones (the paper's
  /// case i, which its vote ignores) and two weak priors that decide where the view says nothing.
  kSupported,
};

/// Knobs of the search. The number of votes is (starting axes, 1..3) x orientations x shifts, each
/// O(points after thinning); `thinning` and `shifts` influence the time most.
struct CompletionOptions {
  int orientations = 15;        // of the plane about each starting axis, odd, >= 1
  double max_angle = 0.349066;  // rad (20 deg): they span +-max_angle, in (0, pi/4]
  int shifts = 41;              // of the plane along its normal, >= 2
  /// Range of the shifts from the thinned cloud's centre, away from the viewer, as a fraction of
  /// the seen cloud's extent along the table. Planes before the centre can only be right when
  /// more of the far side than of the near side was seen, so little of that is searched.
  double min_shift = -0.15;
  double max_shift = 0.75;
  /// Side of the voxels in which one point each votes, as a fraction of the extent, in (0, 0.2].
  double thinning = 0.02;
  /// Also start from the sides of the smallest rectangle round the footprint. The eigenvectors of
  /// a box seen over its edge point along its diagonals, up to 45 deg off its planes of symmetry.
  bool footprint_axes = true;
  /// Bisect angle and shift round the best plane of each starting axis, below the grid's step, and
  /// take the middle of the shifts that are as good as the best one within 0.02 of its vote.
  bool refine = true;

  VoteKind vote = VoteKind::kSupported;
  /// Distances are measured in units of this fraction of the extent, so that a vote is a number
  /// without unit, the same for a near and a far, a coarse and a fine camera. > 0.
  double reference_fraction = 0.05;
  double outside_weight = 1;   // of E[(distance to the mask)^2], >= 0
  double in_front_weight = 1;  // of E[depth before the seen surface], >= 0
  /// Depth differences below this are noise of the sensor [m], > 0.
  double depth_tolerance = 0.003;
  double support_weight = 1;         // kSupported, >= 0
  double oblique_weight = 0.02;      // kSupported: of 1 - cos(angle between normal and view), >= 0
  double depth_prior_weight = 0.01;  // kSupported: of |depth / width - 1| when completed, >= 0

  /// Mirror the completed cloud once more at a plane perpendicular to the first, when one exists
  /// whose contradiction stays below `max_second_vote`. One plane leaves the far side of a box
  /// that was seen over its edge open.
  bool second_plane = true;
  double max_second_vote = 0.02;  // >= 0, in the vote's unit
  /// Leave out mirrored points that lie where the camera looked through, beyond the tolerance.
  bool drop_contradicted = true;
};

/// The method as published: kContradiction, one plane, one starting axis, the grid alone, and
/// every mirrored point kept.
CompletionOptions as_published();

/// Completes an object seen from one side by the vertical plane of symmetry that contradicts the
/// view least (Bohg, Johnson-Roberson, León, Felip, Gratal, Bergström, Kragic, Morales: "Mind the
/// Gap - Robotic Grasping under Incomplete Observation", ICRA 2011, section II).
///
/// The plane stands on the table. It starts along the eigenvector of the cloud's projection onto
/// the table that is most perpendicular to the viewing direction, is turned and shifted away from
/// the viewer, and the cloud is mirrored at it. With q a mirrored point, l = reference_fraction *
/// extent and z the depth along the optical axis, the vote is
///
///     V =   outside_weight  * E[(d(q) / l)^2]        for q outside the mask
///         + in_front_weight * E[(z_seen - z_q) / l]  for q within it, before the seen surface
///
/// with d(q) the distance of q's pixel to the mask, as metres at q's depth (a distance transform),
/// and both E means over all mirrored points. A depth difference within `depth_tolerance` counts
/// as none, as does a point that projects outside the image: nobody looked there.
/// kSupported adds
///
///     support_weight * (1 - s),   s = (C + k/2) / (C + F + k),   k = 2 % of the points,
///
/// C the points that come to lie on the seen surface although the mirror moved them, F those that
/// contradict the view. Points that would be hidden count for nothing, so a plane that maps the
/// seen top face onto itself has s = 1. This settles what V leaves flat: V grows only with the
/// third power of a small shift. A plane *in* the seen surface, for which V = 0 as well, gains no
/// support, since points that the mirror hardly moves are not counted. Where nothing of the top was
/// seen, only the two priors are left: as deep as wide, mirrored straight away from the viewer.
///
/// The result's cloud is the seen points in their order, then each mirrored copy. It does not
/// depend on the order of the points but for that, and moves with a rigid motion of everything.
/// Cost: 0.1-0.4 s for an object of 10^4 points with the defaults.
/// @throws geometry::InputError when fewer than 10 points are given, when one is not finite, all
/// lie on a line or in a plane, are behind the camera or mostly outside the mask, or the mask is
/// empty or not of the camera's size.
/// @throws std::invalid_argument naming the option that is out of range.
CompletedShape complete_by_symmetry(const ObjectView& view, const CompletionOptions& options = {});

}  // namespace prehend::shape
