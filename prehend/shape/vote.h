#pragma once

#include <cstddef>

namespace prehend::shape {

/// What decides how one mirrored point is judged. Lengths in metres.
struct VoteOptions {
  /// Depth differences below this are noise of the sensor, > 0.
  double depth_tolerance = 0.003;
  /// A mirrored point supports its plane only when the mirror moved it further than this, >= 0:
  /// points in the plane coincide with themselves whatever the plane.
  double least_motion = 0.006;
};

/// The unit of depth that equation (3) adds to square pixels [m]. The paper does not say which; in
/// millimetres neither term drowns the other, as a pixel is about one at half a metre.
inline constexpr double kPublishedDepthUnit = 1e-3;

/// By how much the depth of a mirrored point must be smaller for equation (3) to count it [m]: what
/// single precision of the clouds resolves. Points in the plane are mirrored onto themselves.
inline constexpr double kNearer = 1e-6;

/// What one view says about all points of one object mirrored at one plane: sums over the points.
/// tests/oracles/reference_vote.h defines every term; fast_vote.h computes the same to float
/// accuracy.
struct VoteTally {
  std::size_t points = 0;  // mirrored points, n
  // Of equation (3) as it is published: pixels, without tolerance.
  double outside_points = 0;  // points whose pixel is outside the mask
  double outside_pixels = 0;  // squared distance of those pixels to the nearest of the mask [px^2]
  double nearer_points = 0;   // points within the mask, nearer than the pixel they hide
  double nearer = 0;          // depth by which they are [m]
  // Of our own vote.
  double outside_squared = 0;  // squared distance to the mask [m^2]
  double in_front = 0;         // depth before the seen surface, less the tolerance [m]
  double coincident = 0;       // 1 on the seen surface, falling to 0 at the tolerance
  double contradicted = 0;     // 1 where the camera looked through, 0 where it agrees or is hidden
  double hidden = 0;           // points behind the seen surface, beyond the tolerance
  double unseen = 0;           // points behind the camera or beside its image: nobody looked there

  /// The paper's vote (equation 3): two expectations, each over its own points, added without
  /// weights,
  ///
  ///     v = E_{q outside the mask}[squared distance to the mask]
  ///       + E_{q within it, nearer than the pixel it hides}[depth by which it is],
  ///
  /// in square pixels and in units of kPublishedDepthUnit; 0 where there are no such points.
  /// Smaller is better.
  double published_vote() const {
    const double outside = outside_points > 0 ? outside_pixels / outside_points : 0;
    const double depth = nearer_points > 0 ? nearer / nearer_points : 0;
    return outside + depth / kPublishedDepthUnit;
  }
};

}  // namespace prehend::shape
