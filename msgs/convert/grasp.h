#pragma once

#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "prehend/grasp/grasp.h"
#include "prehend/grasp/known/grasp_memory.h"
#include "prehend/grasp/known/known_objects.h"
#include "prehend/robot/hand_model.h"

namespace prehend::convert {

msgs::PredictedPercepts to_message(const grasp::PredictedPercepts& predicted);
/// Of a grasp of this hand, without the arm's motion and how the hand closes (cycle.h).
msgs::Grasp to_message(const grasp::Grasp& grasp, const robot::HandModel& hand);

/// Adds where candidates fell.
void add_rejections(const std::vector<grasp::Rejection>& rejections, msgs::GraspPlan* plan);

msgs::KnownObject to_message(const grasp::Recognition& recognition);
/// @throws InputError without a hash, and for what geometry.h's conversions refuse.
grasp::PlacedObject from_message(const msgs::KnownObject& message);

}  // namespace prehend::convert
