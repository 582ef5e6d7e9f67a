#include "msgs/convert/decision.h"

namespace prehend::convert {
namespace {

using planning::Act;

constexpr bool is_act(Act value, msgs::Choice::Act message) {
  return static_cast<int>(value) == static_cast<int>(message);
}

static_assert(is_act(Act::kGrasp, msgs::Choice::GRASP));
static_assert(is_act(Act::kTouch, msgs::Choice::TOUCH));
static_assert(is_act(Act::kLook, msgs::Choice::LOOK));
static_assert(is_act(Act::kGiveUp, msgs::Choice::GIVE_UP));
static_assert(is_act(Act::kProbe, msgs::Choice::PROBE));
static_assert(is_act(Act::kProbe, msgs::Choice::Act_MAX), "a new one has none here");

}  // namespace

void add_choices(const std::vector<planning::Choice>& choices, msgs::GraspPlan* plan) {
  for (const planning::Choice& choice : choices) {
    msgs::Choice& message = *plan->add_choices();
    message.set_act(static_cast<msgs::Choice::Act>(choice.act));
    message.set_grasp(choice.grasp);
    message.set_success(choice.success);
    message.set_worth(choice.worth);
    message.set_text(choice.text);
  }
}

}  // namespace prehend::convert
