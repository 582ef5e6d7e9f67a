#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/shape/completed_shape.h"

namespace prehend::shape {

/// @throws geometry::InputError when the camera has no size or focal length, the mask is empty or
/// not of the camera's size, a point is not finite or behind the camera, or less than half of the
/// points project into the mask or beside it.
void check_view(const ObjectView& view);

/// A window of the camera's image, in whole pixels.
struct PixelWindow {
  int u0 = 0, v0 = 0;  // first column and row
  int u1 = 0, v1 = 0;  // one past the last

  int width() const { return u1 - u0; }
  int height() const { return v1 - v0; }
};

/// What the camera saw, packed for one look-up per mirrored point: one float per pixel of a window,
/// with a ring of one pixel round it.
///
///     value > 0   within the mask: depth of the seen surface [m]; where something stands before
///                 the object, its depth: what is behind may be there
///     value < 0   outside: minus (distance to the mask - 1/2) [pixels]
///     value = 0   beside the image, or no depth known: nobody looked there
///
/// Where the window ends within the image its ring repeats the last pixel, so a point further out
/// counts as if it were there: too little, never too much.
struct SeenMap {
  PixelWindow window;
  int stride = 0;             // window.width() + 2
  std::vector<float> values;  // stride * (window.height() + 2), row-major; first is (u0-1, v0-1)

  float at(int u, int v) const {
    return values[static_cast<std::size_t>(v - window.v0 + 1) * stride + (u - window.u0 + 1)];
  }
};

/// What a view says about one point that was not itself seen.
struct PointEvidence {
  double coincident = 0;    // 1 on the seen surface, falling to 0 at the tolerance
  double contradicted = 0;  // 0 agrees or hidden, 1 lies clearly where the camera looked through
  double behind = 0;        // depth behind the seen surface [m], where hidden
  bool unseen = false;      // behind the camera or beside its image
};

/// The terms of reference_tally (tests/oracles/reference_vote.h) for one point, in the optical
/// frame C [m]. O(1).
PointEvidence evidence_about(const SeenMap& map, const geometry::PinholeCamera& camera,
                             const Eigen::Vector3d& p_C, double depth_tolerance);

/// The smallest window that holds the mask, the points and all of them mirrored at any of
/// `planes_C` (optical frame C), within the image. O(points + planes).
PixelWindow window_of_mirrored(const ObjectView& view,
                               const std::vector<geometry::Plane>& planes_C);

/// The window of the mask and the points, grown by `margin` of its longer side to every side.
PixelWindow window_round_object(const ObjectView& view, double margin);

/// The same distances and depths as reference_images (tests/oracles/reference_vote.h), once, within
/// `window`. O(pixels of the window) but where points are sparse: O(pixels x distance to the next
/// point).
/// @pre `window` holds the mask and all points that project into the image.
SeenMap make_seen_map(const ObjectView& view, const PixelWindow& window);

}  // namespace prehend::shape
