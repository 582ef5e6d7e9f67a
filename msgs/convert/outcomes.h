#pragma once

#include "msgs/grasp.pb.h"
#include "prehend/control/cycle.h"
#include "prehend/control/surprise.h"
#include "prehend/control/task.h"
#include "prehend/grasp/plan_outcome.h"
#include "prehend/motion/segment.h"

// What plans and cycles decide by. A message's enum is the library's, value for value.
//
// Those that read throw geometry::InputError for a value that the library does not have, from a
// sender that is newer, older, or wrong.
namespace prehend::convert {

msgs::ArmSegment::Kind to_message(motion::SegmentKind kind);
motion::SegmentKind from_message(msgs::ArmSegment::Kind kind);

msgs::GraspPlan::Outcome to_message(grasp::PlanOutcome outcome);
/// Of a plan that has grasps when, and only when, it is graspable; others are refused, too.
grasp::PlanOutcome outcome_of(const msgs::GraspPlan& plan);
/// What a plan says; of one whose outcome_of() is refused, that it failed, and what is wrong.
grasp::PlanAnswer answer_of(const msgs::GraspPlan& plan);

msgs::CycleState::Phase to_message(control::Phase phase);
control::Phase from_message(msgs::CycleState::Phase phase);

msgs::CycleResult::Outcome to_message(control::CycleOutcome outcome);
control::CycleOutcome from_message(msgs::CycleResult::Outcome outcome);

msgs::Task::Action to_message(control::Primitive primitive);
control::Primitive from_message(msgs::Task::Action action);

msgs::Surprise::Kind to_message(control::SurpriseKind kind);
control::SurpriseKind from_message(msgs::Surprise::Kind kind);

}  // namespace prehend::convert
