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

/// What one view says about all points of one object mirrored at one plane: sums over the points.
/// reference_vote.h defines every term; fast_vote.h computes the same to float accuracy.
struct VoteTally {
  std::size_t points = 0;      // mirrored points, n
  double outside = 0;          // distance to the mask [m]
  double outside_squared = 0;  // its square [m^2]
  double in_front = 0;         // depth before the seen surface, less the tolerance [m]
  double coincident = 0;       // 1 on the seen surface, falling to 0 at the tolerance
  double contradicted = 0;     // 1 where the camera looked through, 0 where it agrees or is hidden
  double hidden = 0;           // points behind the seen surface, beyond the tolerance
  double unseen = 0;           // points behind the camera or beside its image: nobody looked there

  /// The paper's vote (equation 4): expected distance outside the mask plus expected depth before
  /// the seen surface, over all points [m]. Smaller is better.
  double published_vote() const {
    return points == 0 ? 0 : (outside + in_front) / static_cast<double>(points);
  }
};

}  // namespace prehend::shape
