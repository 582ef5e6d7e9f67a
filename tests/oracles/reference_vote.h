#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/shape/completed_shape.h"
#include "prehend/shape/vote.h"

namespace prehend::shape {

// The method of Bohg, Johnson-Roberson, León, Felip, Gratal, Bergström, Kragic and Morales, "Mind
// the Gap - Robotic Grasping under Incomplete Observation", ICRA 2011, section II.A, step by step
// in plain double precision. It is slow and stays so: fast_vote.h is tested against it.
//
// Its equations in our words. The cloud P = {p} is projected onto the table; c is the projection's
// mean, e_a and e_b its eigenvectors, v the viewing direction along the table.
//
//   (1)  s = e_a if |e_a · v| <= |e_b · v| else e_b: the plane's trace on the table is the
//        eigenvector most perpendicular to the view; its normal n is s turned by 90 deg, pointing
//        away from the viewer.
//   (2)  Hypotheses (i, j): n_j = n turned by alpha_j in [-20 deg, 20 deg] about the table's
//        normal, through c_ij = c + d_ij n_j with shifts d_ij >= 0 away from the viewer, and
//        p' = p - 2 n_j (n_j · (p - c_ij)).
//   (3)  p' is seen again by the camera at a pixel q. With O the object's mask,
//          vote_ij = E over the q outside O of the squared distance to the nearest pixel of O (a
//                    distance transform)
//                  + E over the q in O whose depth is smaller than that of the pixel they hide, of
//                    the difference of the depths.
//        Each expectation is over its own points alone. No weight stands between the two, and no
//        unit of depth is given: see kPublishedDepthUnit.
//   (4)  The plane with the least vote wins.
//
// A p' that coincides with a seen point (i) supports the plane, one behind a seen point (ii) agrees
// with it, one that is before a seen point or beside the mask (iii) contradicts it; the vote is
// made of (iii) alone. The numbers of orientations and shifts (7 and 5, so 35 hypotheses) and the
// shifts of j/10 of the distance from the centre to the point farthest from the viewer are those of
// the authors' released program (jbohg/mirror_objects, src/predictObject.cc), as is the nearest
// seen depth where a pixel of the mask has none.

/// What the camera saw, over its whole image.
struct SeenImages {
  geometry::Image<double> distance;  // from each pixel's centre to the nearest of the mask [pixels]
  geometry::Image<double> depth;     // of the seen point nearest in the image [m]; 0 without points
};

/// The distance transform of the view's mask and the depth of its points. A pixel with several
/// points takes the nearest one's depth; one without takes that of the nearest pixel that has one,
/// and of equally near ones the least depth. What stands before the object counts as mask, with
/// its own depth: what is behind it is hidden. O(width * height * (width + height)).
/// @throws geometry::InputError as check_view (seen_map.h) does.
SeenImages reference_images(const ObjectView& view);

/// Equation (3) for all points of the view mirrored at `plane_C` (optical frame), summed, and what
/// our own vote is made of. With (u, v) the pixel p' rounds to, f = (fx + fy)/2, t the depth
/// tolerance,
///
///     unseen             1 for p' behind the camera or beside the image: nobody looked there;
///     (iii) outside_...  points 1, pixels distance(u, v)^2; with d = (distance(u, v) - 1/2) z'/f
///                        squared d^2, contradicted ramp(d / (t/2));
///     (iii) nearer       b = depth(u, v) - z' where it is > 0, nearer_points 1;
///     (iii) in_front     max(0, b - t), contradicted ramp(b / t);
///     (i)   coincident   max(0, 1 - |b| / t) when the mirror moved p by more than least_motion;
///     (ii)  hidden       1 when b < -t;
///
/// ramp(x) = min(1, max(0, x - 1/2)). Half a pixel is taken off because pixels are squares.
/// O(points).
VoteTally reference_tally(const ObjectView& view, const SeenImages& images,
                          const geometry::Plane& plane_C, const VoteOptions& options);

/// Equation (1): centre c on the table [m] and normal n (unit, along the table, away from the
/// viewer) of the plane the search starts from, both in W.
struct StartingPlane {
  Eigen::Vector3d center_W;
  Eigen::Vector3d normal_W;
};
StartingPlane reference_start(const ObjectView& view);

/// Equation (2): `orientations` x `shifts` planes in the optical frame C, orientation by
/// orientation. One orientation means alpha = 0. @pre both >= 1.
std::vector<geometry::Plane> reference_hypotheses(const ObjectView& view, int orientations,
                                                  int shifts, double max_angle);

/// Votes for each plane, from scratch: images anew for each hypothesis. Nearly all of the time goes
/// into the exhaustive distance transforms; the votes alone cost about 20 ns per mirrored point.
std::vector<VoteTally> reference_votes(const ObjectView& view,
                                       const std::vector<geometry::Plane>& planes_C,
                                       const VoteOptions& options);

}  // namespace prehend::shape
