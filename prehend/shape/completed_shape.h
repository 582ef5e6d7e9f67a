#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/shape/confidence.h"
#include "prehend/shape/seen_space.h"

namespace prehend::shape {

/// What completion needs of one object seen from one view. All geometry in one frame W (any frame).
struct ObjectView {
  const geometry::PointCloud& cloud_W;  // seen points, finite
  const geometry::MaskImage& mask;      // whole image, 255 where the object is seen
  const geometry::PinholeCamera& camera;
  const geometry::RigidTransform& X_WC;  // optical frame in W
  const geometry::Plane& table_W;        // normal towards the object
  /// Depth [m] of what stands before the object, of the whole image, 0 elsewhere; what it hides
  /// nobody saw. Null or empty: nothing does.
  const geometry::DepthImage* nearer = nullptr;
  bool on_another = false;  // the plane is no table but another object's top
  /// Depth [m] of everything that was seen, of the whole image, NaN where unknown. Null or empty:
  /// not given, and the shape's `seen_space` is empty.
  const geometry::DepthImage* depth = nullptr;
  bool may_be_several = false;  // ObjectHypothesis::may_be_several
  bool is_cut = false;          // ObjectHypothesis::touches_image_border: it goes on
};

/// Whose viewpoint a point was "seen" from (CompletedShape::viewpoint_of). Points that a fall-back
/// made count as kMirrored on the far side of its nominal plane and as kMirroredSecond on the near.
enum class PointOrigin : std::uint8_t {
  kSeen = 0,
  kMirrored = 1,        // of a seen point, at the plane of symmetry
  kMirroredSecond = 2,  // of a seen point, at the second plane
  kMirroredBoth = 3,    // of a seen point, at both
};

/// What the view says about a point of the completed shape.
enum class PointSupport : std::uint8_t {
  kSeen = 0,       // it is a seen point
  kSupported = 1,  // predicted, and coincides with the seen surface
  kOccluded = 2,   // predicted into space that the seen surface hides: a guess
  kUnseen = 3,     // predicted to where nobody looked, beside the image: a guess
};

/// One plane of symmetry, vertical or nearly so, and how well it agrees with what was seen.
struct SymmetryHypothesis {
  Eigen::Vector3d point_W = Eigen::Vector3d::Zero();    // on the plane [m]
  Eigen::Vector3d normal_W = Eigen::Vector3d::UnitX();  // unit, along the table unless tilted
  double vote = 0;                                      // smaller is better
  // What the vote is made of, see symmetry.h; fractions are of the mirrored points.
  double outside = 0;       // E[(distance to the mask / reference length)^2]
  double in_front = 0;      // E[depth before the seen surface / reference length]
  double coincident = 0;    // fraction that lies on the seen surface
  double contradicted = 0;  // fraction that lies where the camera looked through
  double unseen = 0;        // fraction of which the view says nothing: beside the image
};

/// Of two mirrors, one whose vote is worse by this is less likely by e: fitted to views of known
/// objects (eval_belief --fit-prior).
inline constexpr double kVoteScale = 0.4;

/// `p` mirrored at the plane of `symmetry`.
inline Eigen::Vector3d mirrored(const SymmetryHypothesis& symmetry, const Eigen::Vector3d& p_W) {
  return p_W - 2 * symmetry.normal_W.dot(p_W - symmetry.point_W) * symmetry.normal_W;
}

/// The seen points followed by the predicted ones.
struct CompletedShape {
  /// Of a fall-back with normals: outward where it made the points, zero where they were seen.
  geometry::PointCloud cloud_W;
  std::vector<PointOrigin> origin;      // one per point
  std::vector<PointSupport> support;    // one per point
  std::vector<float> point_confidence;  // one per point: probability that the surface is there
  /// The winner; for a fall-back a nominal vertical plane through its middle, facing the viewer.
  SymmetryHypothesis symmetry;
  std::vector<SymmetryHypothesis> planes;      // best distinct planes, best first
  std::vector<SymmetryHypothesis> hypotheses;  // the winner, then all that were tried, best first
  CompletionMethod method = CompletionMethod::kMirror;
  std::string refused;  // why better methods were not used, in words; empty for a good plane
  Evidence evidence;
  double confidence = 0;  // of the whole, see confidence.h
  /// Mean of point_confidence over the points of each PointOrigin; 0 where there are none.
  std::array<double, 4> region_confidence{};
  Eigen::Vector3d viewpoint_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d mirrored_viewpoint_W = Eigen::Vector3d::Zero();
  std::optional<SymmetryHypothesis> second_symmetry;  // perpendicular to `symmetry`, if any
  /// What the object may look like as well, best first: completions by other planes that the view
  /// speaks for nearly as well (CompletionOptions::alternatives). They have none themselves, and
  /// no `planes` and `hypotheses`.
  std::vector<CompletedShape> alternatives;
  /// What it would be by other methods (CompletionOptions::other_methods): likelier than they look
  /// once something was felt. As alternatives, but no grasps are planned on them.
  std::vector<CompletedShape> other_methods;
  /// Where the view looked through, round the points of this shape and of its alternatives (which
  /// have none themselves): no surface between the points may go there. Without size where the view
  /// had no depth.
  SeenSpace seen_space;
  /// Planes to whose normal's side the body keeps, alternatives and other methods' too: neighbours
  /// begin there (neighbors.h).
  std::vector<geometry::Plane> bounds_W;

  /// Where a point of origin `point_origin` was "seen" from: the camera or its mirror image [m].
  Eigen::Vector3d viewpoint_of(PointOrigin point_origin) const {
    const bool first =
        point_origin == PointOrigin::kMirrored || point_origin == PointOrigin::kMirroredBoth;
    const bool second =
        point_origin == PointOrigin::kMirroredSecond || point_origin == PointOrigin::kMirroredBoth;
    const Eigen::Vector3d viewpoint = first ? mirrored_viewpoint_W : viewpoint_W;
    return second && second_symmetry ? mirrored(*second_symmetry, viewpoint) : viewpoint;
  }
};

/// Sets `region_confidence` from `point_confidence` and `origin`.
inline void set_region_confidence(CompletedShape& shape) {
  std::array<double, 4> sums{}, counts{};
  for (std::size_t i = 0; i < shape.point_confidence.size(); ++i) {
    const auto region = static_cast<std::size_t>(shape.origin[i]);
    sums[region] += static_cast<double>(shape.point_confidence[i]);
    counts[region] += 1;
  }
  for (std::size_t r = 0; r < sums.size(); ++r) {
    shape.region_confidence[r] = counts[r] > 0 ? sums[r] / counts[r] : 0;
  }
}

}  // namespace prehend::shape
