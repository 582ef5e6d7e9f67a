#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/shape/completed_shape.h"
#include "prehend/shape/vote.h"

namespace prehend::shape {

// The method of Bohg, Johnson-Roberson, León, Felip, Gratal, Bergström, Kragic and Morales, "Mind
// the Gap - Robotic Grasping under Incomplete Observation", ICRA 2011, section III, step by step in
// plain double precision. It is slow and stays so: fast_vote.h is tested against it.
//
// Section III in our words and numbering. The cloud P = {p} is projected onto the table; c is the
// projection's mean, e_a and e_b its eigenvectors, v the viewing direction along the table.
//
//   (1)  s = e_a if |e_a · v| <= |e_b · v| else e_b: the plane's trace on the table is the
//        eigenvector most perpendicular to the view; its normal n is s turned by 90 deg, pointing
//        away from the viewer.
//   (2)  Hypotheses (i, j): n_j = n turned by alpha_j in [-20 deg, 20 deg] about the table's
//   normal,
//        through c_ij = c + d_ij n_j with shifts d_ij >= 0 away from the viewer.
//   (3)  p' = p - 2 n_j (n_j · (p - c_ij)). Seen again by the camera, p'
//          (i)   coincides with a seen point: supports the hypothesis;
//          (ii)  lies behind a seen point: hidden, agrees;
//          (iii) lies before a seen point, or projects beside the object's mask, where the camera
//                saw something further away: contradicts, by the depth difference or by the
//                distance to the mask's border (a distance transform).
//   (4)  vote_ij = E[distance to the mask] + E[depth before the seen surface]; the least wins.
//
// What could be verified in public text: the authors' released program (jbohg/mirror_objects,
// src/predictObject.cc) for the eigenvectors, +-20 deg in 7 orientations, 5 shifts (so 35
// hypotheses), shifts of j/10 of the distance from the centre to the point farthest from the
// viewer, the cases and the nearest seen depth where a pixel has none; the implementation of A.
// Huaman Quispe (PCL, 2014) for the rule that chooses the eigenvector and for the distance
// transform. What could not, because the paper's text is not freely stored: the literal form of its
// equations (1)-(4). In particular E may be over the contradicting points only, as in both
// programs; here it is over all points, so that one stray pixel does not weigh as much as half of
// the cloud. The released program measures points outside the mask by depth difference, the paper
// by a distance transform; we follow the paper. Both distances are metres here (pixels times depth
// over focal length), so that they can be added without weights.

/// What the camera saw, over its whole image.
struct SeenImages {
  geometry::Image<double> distance;  // from each pixel's centre to the nearest of the mask [pixels]
  geometry::Image<double> depth;     // of the seen point nearest in the image [m]; 0 without points
};

/// The distance transform of the view's mask and the depth of its points. A pixel with several
/// points takes the nearest one's depth; one without takes that of the nearest pixel that has one,
/// and of equally near ones the least depth. O(width * height * (width + height)).
/// @throws geometry::InputError as check_view (seen_map.h) does.
SeenImages reference_images(const ObjectView& view);

/// Equation (3) for all points of the view mirrored at `plane_C` (optical frame), summed. With
/// (u, v) the pixel p' rounds to, f = (fx + fy)/2, t the depth tolerance,
///
///     unseen             1 for p' behind the camera or beside the image: nobody looked there;
///     (iii) outside      d = (distance(u, v) - 1/2) z'/f, contradicted ramp(d / (t/2));
///     (iii) in_front     max(0, b - t) with b = depth(u, v) - z', contradicted ramp(b / t);
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
