#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prehend/shape/seen_map.h"
#include "prehend/shape/voting_points.h"

namespace prehend::shape {

/// Points that a fall-back predicts in the frame T of VotingPoints, and how well they agree with
/// the view.
struct Fallback {
  CompletionMethod method = CompletionMethod::kConvexHull;
  std::vector<Eigen::Vector3d> points_T;
  std::vector<Eigen::Vector3d> normals_T;              // one a point, unit, outward
  Eigen::Vector2d center_T = Eigen::Vector2d::Zero();  // of the predicted solid, on the table
  double contradicted = 0;  // mean of PointEvidence::contradicted over the points
  double coincident = 0;    // mean of PointEvidence::coincident
  double unseen = 0;        // fraction of the points
  double misfit = 0;  // kRotation: root mean square distance of the sides to it, of the extent

  /// Smaller is better: what contradicts the view, and what does not fit.
  double score() const { return contradicted + misfit; }
};

/// What the fall-backs need; the references are kept only during the call.
struct FallbackInput {
  const VotingPoints& voting;
  const SeenMap& map;
  const geometry::PinholeCamera& camera;
  geometry::RigidTransform X_CT;
  double depth_tolerance;  // m
  double spacing;          // m, between predicted points, > 0
};

/// A surface of revolution about a vertical axis. In each slice of the seen cloud the points of the
/// convex outline lie on a circle about the common axis, so x^2 + y^2 = 2 a x + 2 b y + c_slice;
/// solved for (a, b) by least squares that trusts far points less (handles, spouts), then the
/// median radius of each slice. Nothing when the seen sides span too little of a circle to tell.
std::optional<Fallback> revolved(const FallbackInput& input);

/// The seen outline carried down to the table: walls under the border of the footprint's cells,
/// from the greatest height seen over each. Nothing when only an upright face was seen: its
/// footprint is a line.
std::optional<Fallback> extruded(const FallbackInput& input);

/// The convex hull of the seen points and of their projection on the table, sampled. Always there.
std::optional<Fallback> hulled(const FallbackInput& input);

}  // namespace prehend::shape
