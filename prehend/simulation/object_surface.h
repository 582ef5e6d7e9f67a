#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/geometry/mesh_query.h"
#include "prehend/simulation/rigid_body.h"

namespace prehend::simulation {

/// How deep a point is in what it touches.
struct Depth {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, outward
  double depth = 0;                                   // m, negative: a gap
};

/// The surface of an object, in its frame B, as points of others meet it: boxes, balls and cans as
/// such, other objects by their mesh. What is far is told by a grid of cells without a search.
///
/// Where walls are thinner than kThinWall, the nearest face may be the other side's: rubber gives
/// way by more than half of a cup's wall. A point of a body belongs to the side that the body has
/// come from, which its inward normal tells.
class ObjectSurface {
 public:
  static constexpr double kDeepest = 0.01;    // m, deeper the nearest face is a guess
  static constexpr double kThinWall = 0.005;  // m

  explicit ObjectSurface(const BodyModel& model);

  /// Of a point p_B [m] that is inside, or outside by less than `margin` [m].
  std::optional<Depth> at(const Eigen::Vector3d& p_B, double margin) const;
  /// The same of a point of a body whose surface there has the outward normal `outward_B` (unit, or
  /// zero: not known).
  std::optional<Depth> met_by(const Eigen::Vector3d& p_B, const Eigen::Vector3d& outward_B,
                              double margin) const;

 private:
  /// p_B is outside, this far from the surface at least [m]; 0 when it may be inside.
  double outside_by(const Eigen::Vector3d& p_B) const;
  /// The wall that is within the body behind a point of its surface.
  std::optional<Depth> wall_within(const Eigen::Vector3d& p_B,
                                   const Eigen::Vector3d& outward_B) const;

  FeltShape felt_;
  std::shared_ptr<const geometry::MeshQuery> query_;
  bool has_thin_walls_ = false;
  // The grid of cells, of a mesh.
  Eigen::AlignedBox3d box_;  // m, in B
  Eigen::Vector3i cells_ = Eigen::Vector3i::Zero();
  double side_ = 0;               // m
  std::vector<float> clearance_;  // m, of each cell's middle from the surface, 0 inside; at most
                                  // what is asked for
};

}  // namespace prehend::simulation
