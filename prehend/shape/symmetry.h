#pragma once

#include "prehend/shape/completed_shape.h"
#include "prehend/shape/completion_options.h"

namespace prehend::shape {

/// Completes an object seen from one side by the plane of symmetry that contradicts the view least
/// (after Bohg, Johnson-Roberson, León, Felip, Gratal, Bergström, Kragic, Morales: "Mind the Gap -
/// Robotic Grasping under Incomplete Observation", ICRA 2011; see
/// tests/oracles/reference_vote.h).
///
/// The plane stands on the table, or leans a little where the view asks for it. All its directions
/// and plausible shifts are tried (plane_search.h). With q a mirrored point, l =
/// reference_fraction * extent and z the depth along the optical axis, the vote is
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
/// When every plane would put more than `max_contradicted` of its points where the camera looked
/// through, or has a support s below `min_support`, the first of these that does not contradict the
/// view much completes the shape instead (fallbacks.h): a surface of revolution about a vertical
/// axis, an extrusion to the table, the convex hull of what was seen and its shadow. When none of
/// the three is good, the least bad of them. None is used that puts a larger share of its points
/// where the camera looked through than the refused plane did: when all do, the plane serves after
/// all, with little confidence. `method` and `refused` say what was used and why.
///
/// The result's cloud is the seen points in their order, then the predicted ones, each with what
/// the view says about it and how sure it is (confidence.h). It does not depend on the order of the
/// points but for that, nor on threads, and moves with a rigid motion of everything.
/// Cost: 10-40 ms for an object of 10^4 points with the defaults.
/// @throws geometry::InputError when fewer than 10 points are given, when one is not finite, all
/// lie on a line or in a plane, are behind or round the camera or mostly outside the mask, or the
/// mask is empty or not of the camera's size.
/// @throws std::invalid_argument naming the option that is out of range.
CompletedShape complete_by_symmetry(const ObjectView& view, const CompletionOptions& options = {},
                                    const ConfidenceModel& model = {});

}  // namespace prehend::shape
