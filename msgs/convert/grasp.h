#pragma once

#include "msgs/grasp.pb.h"
#include "prehend/grasp/planner.h"

namespace prehend::convert {

msgs::Grasp to_message(const grasp::Grasp& grasp);
/// @throws InputError for NaN, an approach that is not a unit vector, an opening, distance or force
/// that is not positive, and for what geometry.h's conversions refuse.
grasp::Grasp from_message(const msgs::Grasp& message);

/// Adds where candidates fell.
void add_rejections(const std::vector<grasp::Rejection>& rejections, msgs::GraspPlan* plan);

/// Fills grasps, rejections, candidates and problem.
msgs::GraspPlan to_message(const grasp::GraspPlanResult& plan);

}  // namespace prehend::convert
