#pragma once

#include <optional>
#include <vector>

#include "prehend/grasp/generators/generator.h"

namespace prehend::grasp {

/// Where the fingers shall touch: a line through the object.
struct HeldLine {
  Eigen::Vector3d middle_W = Eigen::Vector3d::Zero();  // m, between the two contacts
  Eigen::Vector3d axis_W = Eigen::Vector3d::UnitY();   // unit, from one to the other
  double width = 0;                                    // m, between them
};

/// The line between the points where rays from far outside meet the object, along `axis_W` and
/// against it through `p_W`; none when they miss it.
std::optional<HeldLine> line_through(const geometry::SurfaceQuery& object_W,
                                     const Eigen::Vector3d& p_W, const Eigen::Vector3d& axis_W);

/// Directions in which a hand that closes along `axis_W` may approach: evenly round the axis,
/// straight at the table first. With a fixed approach, that one, unless it is nearer than 60
/// degrees to the axis.
std::vector<Eigen::Vector3d> approaches_about(const Eigen::Vector3d& axis_W,
                                              const GraspTarget& target, int count);

/// Adds candidates that approach along the unit vector `approach_W` and close on the line (its part
/// perpendicular to the approach), the fingertips at `standoffs` depths beyond the line.
void add_standoffs(const HeldLine& line, const Eigen::Vector3d& approach_W,
                   const GraspTarget& target, const GeneratorOptions& options,
                   std::vector<Candidate>* candidates);

/// Depths of the fingertips beyond the point `p_W` along the approach [m], deepest first: `count`
/// from `shallowest` to `deepest`, none so deep that a vertical approach comes nearer to the table
/// than `clearance`.
std::vector<double> tip_depths(const Eigen::Vector3d& p_W, const Eigen::Vector3d& approach_W,
                               double shallowest, double deepest, int count,
                               const geometry::Plane& table, double clearance);

}  // namespace prehend::grasp
