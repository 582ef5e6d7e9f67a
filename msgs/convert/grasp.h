#pragma once

#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "prehend/grasp/known/grasp_memory.h"
#include "prehend/grasp/known/known_objects.h"
#include "prehend/grasp/planner.h"

namespace prehend::convert {

msgs::PredictedPercepts to_message(const grasp::PredictedPercepts& predicted);
msgs::Grasp to_message(const grasp::Grasp& grasp);
/// @throws InputError for NaN, an approach that is not a unit vector, an opening, distance or force
/// that is not positive, and for what geometry.h's conversions refuse.
grasp::Grasp from_message(const msgs::Grasp& message);

/// Adds where candidates fell.
void add_rejections(const std::vector<grasp::Rejection>& rejections, msgs::GraspPlan* plan);

/// Fills grasps, rejections, candidates and problem.
msgs::GraspPlan to_message(const grasp::GraspPlanResult& plan);

msgs::KnownObject to_message(const grasp::Recognition& recognition);
/// @throws InputError without a hash, and for what geometry.h's conversions refuse.
grasp::PlacedObject from_message(const msgs::KnownObject& message);

}  // namespace prehend::convert
