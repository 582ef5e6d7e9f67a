#include "prehend/grasp/generators/held_line.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "prehend/grasp/generators/directions.h"

namespace prehend::grasp {

std::optional<HeldLine> line_through(const geometry::SurfaceQuery& object_W,
                                     const Eigen::Vector3d& p_W, const Eigen::Vector3d& axis_W) {
  const Eigen::AlignedBox3d& box = object_W.box();
  const double reach = (p_W - box.center()).norm() + box.diagonal().norm() / 2 + 0.01;  // m
  const auto first = object_W.cast_ray(p_W - reach * axis_W, axis_W, 2 * reach);
  const auto last = object_W.cast_ray(p_W + reach * axis_W, -axis_W, 2 * reach);
  if (!first || !last) return std::nullopt;
  const double lower = first->distance - reach, upper = reach - last->distance;
  if (!(upper > lower)) return std::nullopt;
  return HeldLine{p_W + (lower + upper) / 2 * axis_W, axis_W, upper - lower};
}

std::vector<Eigen::Vector3d> approaches_about(const Eigen::Vector3d& axis_W,
                                              const GraspTarget& target, int count) {
  if (target.reachability.approach_W) {
    const Eigen::Vector3d& approach = *target.reachability.approach_W;
    if (std::abs(approach.dot(axis_W)) > 0.5) return {};
    return {approach};
  }
  Eigen::Vector3d first = perpendicular_part(-target.table.normal, axis_W);
  if (first.isZero()) first = frame_about(axis_W).col(0);
  std::vector<Eigen::Vector3d> approaches;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    approaches.push_back((Eigen::AngleAxisd(angle, axis_W) * first).normalized());
  }
  return approaches;
}

std::vector<double> tip_depths(const Eigen::Vector3d& p_W, const Eigen::Vector3d& approach_W,
                               double shallowest, double deepest, int count,
                               const geometry::Plane& table, double clearance) {
  const double descent = -approach_W.dot(table.normal);  // height lost per metre
  if (descent > 0.5) {
    deepest = std::min(deepest, (table.signed_distance(p_W) - clearance) / descent);
  }
  if (count == 1 || deepest <= shallowest) return {std::min(deepest, shallowest)};
  std::vector<double> depths;
  for (int i = 0; i < count; ++i) {
    depths.push_back(deepest + (shallowest - deepest) * i / (count - 1));
  }
  return depths;
}

void add_standoffs(const HeldLine& line, const Eigen::Vector3d& approach_W,
                   const GraspTarget& target, const GeneratorOptions& options,
                   std::vector<Candidate>* candidates) {
  const Eigen::Vector3d closing = perpendicular_part(line.axis_W, approach_W);
  if (closing.isZero()) return;
  Candidate candidate;
  candidate.approach_W = approach_W;
  candidate.outline_width = line.width;
  candidate.X_WG.linear() << closing.cross(approach_W), closing, approach_W;
  const Eigen::Vector3d y_A = frame_about(approach_W).transpose() * closing;
  candidate.roll = std::atan2(-y_A.x(), y_A.y());
  if (candidate.roll < 0) candidate.roll += std::numbers::pi;
  for (const double depth :
       tip_depths(line.middle_W, approach_W, options.least_engagement, target.hand.pad_length,
                  options.standoffs, target.table, options.table_clearance)) {
    const Eigen::Vector3d tip_W = line.middle_W + depth * approach_W;
    candidate.X_WG.translation() = tip_W - target.hand.tip_z * approach_W;
    candidate.standoff = (target.centroid_W - tip_W).dot(approach_W);
    candidate.lateral_offset =
        (candidate.X_WG.translation() - target.centroid_W).dot(candidate.X_WG.linear().col(0));
    candidates->push_back(candidate);
  }
}

}  // namespace prehend::grasp
