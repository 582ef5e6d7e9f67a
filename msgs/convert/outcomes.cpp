#include "msgs/convert/outcomes.h"

#include <fmt/format.h>

#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using control::CycleOutcome;
using control::Phase;
using control::Primitive;
using control::SurpriseKind;
using grasp::PlanOutcome;
using motion::SegmentKind;

template <class Library, class Message>
constexpr bool is_same(Library value, Message message) {
  return static_cast<int>(value) == static_cast<int>(message);
}

static_assert(is_same(SegmentKind::kReach, msgs::ArmSegment::REACH));
static_assert(is_same(SegmentKind::kApproach, msgs::ArmSegment::APPROACH));
static_assert(is_same(SegmentKind::kLift, msgs::ArmSegment::LIFT));
static_assert(is_same(SegmentKind::kCarry, msgs::ArmSegment::CARRY));
static_assert(is_same(SegmentKind::kPlace, msgs::ArmSegment::PLACE));
static_assert(is_same(SegmentKind::kRetreat, msgs::ArmSegment::RETREAT));
static_assert(is_same(SegmentKind::kRetreat, msgs::ArmSegment::Kind_MAX),
              "a new one has none here");

static_assert(is_same(PlanOutcome::kFailed, msgs::GraspPlan::FAILED));
static_assert(is_same(PlanOutcome::kUngraspable, msgs::GraspPlan::UNGRASPABLE));
static_assert(is_same(PlanOutcome::kGraspable, msgs::GraspPlan::GRASPABLE));
static_assert(is_same(PlanOutcome::kGraspable, msgs::GraspPlan::Outcome_MAX),
              "a new one has none here");

static_assert(is_same(Phase::kWaiting, msgs::CycleState::WAITING));
static_assert(is_same(Phase::kSpawn, msgs::CycleState::SPAWN));
static_assert(is_same(Phase::kApproach, msgs::CycleState::APPROACH));
static_assert(is_same(Phase::kGrasp, msgs::CycleState::GRASP));
static_assert(is_same(Phase::kLift, msgs::CycleState::LIFT));
static_assert(is_same(Phase::kMove, msgs::CycleState::MOVE));
static_assert(is_same(Phase::kRelease, msgs::CycleState::RELEASE));
static_assert(is_same(Phase::kDone, msgs::CycleState::DONE));
static_assert(is_same(Phase::kFailed, msgs::CycleState::FAILED));
static_assert(is_same(Phase::kPush, msgs::CycleState::PUSH));
static_assert(is_same(Phase::kPush, msgs::CycleState::Phase_MAX), "a new one has none here");

static_assert(is_same(CycleOutcome::kFailed, msgs::CycleResult::FAILED));
static_assert(is_same(CycleOutcome::kUngraspable, msgs::CycleResult::UNGRASPABLE));
static_assert(is_same(CycleOutcome::kSucceeded, msgs::CycleResult::SUCCEEDED));
static_assert(is_same(CycleOutcome::kSucceeded, msgs::CycleResult::Outcome_MAX),
              "a new one has none here");

static_assert(is_same(Primitive::kLook, msgs::Task::LOOK));
static_assert(is_same(Primitive::kApproach, msgs::Task::APPROACH));
static_assert(is_same(Primitive::kTouch, msgs::Task::TOUCH));
static_assert(is_same(Primitive::kGrasp, msgs::Task::GRASP));
static_assert(is_same(Primitive::kLift, msgs::Task::LIFT));
static_assert(is_same(Primitive::kMove, msgs::Task::MOVE));
static_assert(is_same(Primitive::kPlace, msgs::Task::PLACE));
static_assert(is_same(Primitive::kRelease, msgs::Task::RELEASE));
static_assert(is_same(Primitive::kRetreat, msgs::Task::RETREAT));
static_assert(is_same(Primitive::kWait, msgs::Task::WAIT));
static_assert(is_same(Primitive::kDecide, msgs::Task::DECIDE));
static_assert(is_same(Primitive::kProbe, msgs::Task::PROBE));
static_assert(is_same(Primitive::kInspect, msgs::Task::INSPECT));
static_assert(is_same(Primitive::kView, msgs::Task::VIEW));
static_assert(is_same(Primitive::kPush, msgs::Task::PUSH));
static_assert(is_same(Primitive::kPush, msgs::Task::Action_MAX), "a new one has none here");

static_assert(is_same(SurpriseKind::kOpeningAtContact, msgs::Surprise::OPENING_AT_CONTACT));
static_assert(is_same(SurpriseKind::kContactArea, msgs::Surprise::CONTACT_AREA));
static_assert(is_same(SurpriseKind::kTactileSum, msgs::Surprise::TACTILE_SUM));
static_assert(is_same(SurpriseKind::kHeldAfterLift, msgs::Surprise::HELD_AFTER_LIFT));
static_assert(is_same(SurpriseKind::kTouchedTooEarly, msgs::Surprise::TOUCHED_TOO_EARLY));
static_assert(is_same(SurpriseKind::kFingersTouch, msgs::Surprise::FINGERS_TOUCH));
static_assert(is_same(SurpriseKind::kFingersAtContact, msgs::Surprise::FINGERS_AT_CONTACT));
static_assert(is_same(SurpriseKind::kLiftedWeight, msgs::Surprise::LIFTED_WEIGHT));
static_assert(is_same(SurpriseKind::kHeldWhileCarried, msgs::Surprise::HELD_WHILE_CARRIED));
static_assert(is_same(SurpriseKind::kPlaced, msgs::Surprise::PLACED));
static_assert(is_same(SurpriseKind::kMotion, msgs::Surprise::MOTION));
static_assert(is_same(SurpriseKind::kSlip, msgs::Surprise::SLIP));
static_assert(is_same(SurpriseKind::kSlip, msgs::Surprise::Kind_MAX), "a new one has none here");

// `what` has values from `first` to that of the message's largest.
template <class Library, class Message>
Library known(Message value, Library first, Message last, const char* what) {
  const int number = value;
  if (number < static_cast<int>(first) || number > last) {
    throw geometry::InputError(fmt::format("{} that is unknown ({})", what, number), kSenderMend);
  }
  return static_cast<Library>(number);
}

}  // namespace

msgs::ArmSegment::Kind to_message(SegmentKind kind) {
  return static_cast<msgs::ArmSegment::Kind>(kind);
}

SegmentKind from_message(msgs::ArmSegment::Kind kind) {
  return known(kind, SegmentKind::kReach, msgs::ArmSegment::Kind_MAX,
               "A grasp with a kind of the arm's segments");
}

msgs::GraspPlan::Outcome to_message(PlanOutcome outcome) {
  return static_cast<msgs::GraspPlan::Outcome>(outcome);
}

PlanOutcome outcome_of(const msgs::GraspPlan& plan) {
  const PlanOutcome outcome = known(plan.outcome(), PlanOutcome::kFailed,
                                    msgs::GraspPlan::Outcome_MAX, "A grasp plan with an outcome");
  if ((outcome == PlanOutcome::kGraspable) != (plan.grasps_size() > 0)) {
    throw geometry::InputError(fmt::format("A grasp plan with the outcome '{}' and {} grasps",
                                           to_string(outcome), plan.grasps_size()),
                               kSenderMend);
  }
  return outcome;
}

grasp::PlanAnswer answer_of(const msgs::GraspPlan& plan) {
  try {
    return {outcome_of(plan), plan.problem()};
  } catch (const geometry::InputError& error) {
    return {PlanOutcome::kFailed, error.what()};
  }
}

msgs::CycleState::Phase to_message(Phase phase) {
  return static_cast<msgs::CycleState::Phase>(phase);
}

Phase from_message(msgs::CycleState::Phase phase) {
  return known(phase, Phase::kWaiting, msgs::CycleState::Phase_MAX, "A cycle in a phase");
}

msgs::CycleResult::Outcome to_message(CycleOutcome outcome) {
  return static_cast<msgs::CycleResult::Outcome>(outcome);
}

CycleOutcome from_message(msgs::CycleResult::Outcome outcome) {
  return known(outcome, CycleOutcome::kFailed, msgs::CycleResult::Outcome_MAX,
               "A cycle's result with an outcome");
}

msgs::Task::Action to_message(Primitive primitive) {
  return static_cast<msgs::Task::Action>(primitive);
}

Primitive from_message(msgs::Task::Action action) {
  return known(action, Primitive::kLook, msgs::Task::Action_MAX, "A task with an action");
}

msgs::Surprise::Kind to_message(SurpriseKind kind) {
  return static_cast<msgs::Surprise::Kind>(kind);
}

SurpriseKind from_message(msgs::Surprise::Kind kind) {
  return known(kind, SurpriseKind::kOpeningAtContact, msgs::Surprise::Kind_MAX,
               "A surprise of a kind");
}

}  // namespace prehend::convert
