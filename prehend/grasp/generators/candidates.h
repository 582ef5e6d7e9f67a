#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::grasp {

/// Which poses of the gripper frame G the robot can take. The default can take every pose.
struct Reachability {
  /// Fixed approach direction (G's z axis, unit, world) of a carrier that only moves along x, y, z
  /// and turns about that axis; unset for an arm that can take any.
  std::optional<Eigen::Vector3d> approach_W;
  double approach_tolerance = 0.02;  // rad, how far a direction may be from `approach_W`
  /// Box for the origin of G, the pregrasp included [m]. An empty box is no limit.
  Eigen::AlignedBox3d workspace_W;

  /// True when a hand approaching along the unit vector `approach` is within the tolerance.
  bool reaches_direction(const Eigen::Vector3d& approach) const {
    if (!approach_W) return true;
    return std::atan2(approach_W->cross(approach).norm(), approach_W->dot(approach)) <=
           approach_tolerance;
  }
  /// True when the point `p_W` is inside the workspace.
  bool reaches_point(const Eigen::Vector3d& p_W) const {
    return workspace_W.isEmpty() || workspace_W.contains(p_W);
  }
};

/// A pose of the open hand to try.
struct Candidate {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();
  Eigen::Vector3d approach_W = -Eigen::Vector3d::UnitZ();  // unit, G's z axis
  double standoff = 0;        // m, from the fingertips forward to the centroid along the approach
  double roll = 0;            // rad, about the approach from the direction of smallest width
  double lateral_offset = 0;  // m, of G's origin from the centroid along G's x axis
  double outline_width = 0;   // m, smallest width of the object's outline seen along the approach
};

struct CandidateOptions {
  int directions_per_circle = 16;   // > 0
  int rolls = 12;                   // > 0, over half a turn: the hand is symmetric about its z axis
  int standoffs = 6;                // > 0, from the least engagement to the deepest
  double least_engagement = 0.012;  // m, > 0, of the fingertips beyond the object's near side
  double table_clearance = 0.005;   // m, >= 0, that the deepest vertical grasp keeps to the table
  /// m, along G's x axis (across the fingers)
  std::vector<double> lateral_offsets{0.0, -0.015, 0.015};

  /// @throws std::invalid_argument naming the field that is out of range.
  void validate() const;
};

/// An object seen along an approach direction.
struct ApproachView {
  Eigen::Matrix3d R_WA;  // z along the approach, y along the smallest width
  double near_side = 0;  // m, along the approach from the centroid, negative
  double far_side = 0;   // m
  double width = 0;      // m, smallest of the outline
};

/// The views of sample_candidates(): the same whatever the hand.
/// @pre `mesh_W` is finite and has at least one triangle.
std::vector<ApproachView> approach_views(const geometry::TriangleMesh& mesh_W,
                                         const Eigen::Vector3d& centroid_W,
                                         const geometry::Plane& table,
                                         const Reachability& reachability,
                                         const CandidateOptions& options);

/// Samples hand poses round the object, in a fixed order.
///
/// Approach directions lie on two perpendicular great circles round the centroid (Bohg et al.,
/// "Mind the gap - robotic grasping under incomplete observation", ICRA 2011, section IV): one
/// about the object's major axis, one containing that axis. The second one starts exactly opposite
/// to the reference direction, which is `reachability.approach_W` or, when unset, straight at the
/// table, so that the vertical approach is always among the samples; a direction of both circles is
/// listed once. Each direction is combined with all rolls, standoffs and lateral offsets. Roll 0
/// closes along the direction of smallest width of the object's outline seen along the approach.
///
/// The pose's y coordinate (along the closing direction) is the centroid's; closing the hand shows
/// how to centre it. Unreachable directions are listed too: rejecting them is the planner's part.
/// `tip_z` [m] is where the fingertips are along G's z axis.
/// @pre `mesh_W` is finite and has at least one triangle.
std::vector<Candidate> sample_candidates(const geometry::TriangleMesh& mesh_W,
                                         const Eigen::Vector3d& centroid_W,
                                         const geometry::Plane& table, double tip_z,
                                         const Reachability& reachability,
                                         const CandidateOptions& options);
/// The same from views that are known, of this object with these options.
std::vector<Candidate> sample_candidates(const std::vector<ApproachView>& views,
                                         const Eigen::Vector3d& centroid_W,
                                         const geometry::Plane& table, double tip_z,
                                         const CandidateOptions& options);

/// Unit eigenvectors of the area-weighted covariance of the surface as columns, longest first,
/// right-handed.
Eigen::Matrix3d principal_axes(const geometry::TriangleMesh& mesh);

/// Smallest distance of two parallel lines that enclose the points (n x 2) and the unit direction
/// across them: rotating calipers on the convex hull.
struct SmallestWidth {
  double width = 0;
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
};
SmallestWidth smallest_width(const std::vector<Eigen::Vector2d>& points);

}  // namespace prehend::grasp
