#include "msgs/convert/remedies.h"

namespace prehend::convert {
namespace {

using planning::RemedyChange;

constexpr bool is_remedy(RemedyChange value, msgs::RemedyAmount::Change message) {
  return static_cast<int>(value) == static_cast<int>(message);
}

static_assert(is_remedy(RemedyChange::kOpening, msgs::RemedyAmount::OPENING));
static_assert(is_remedy(RemedyChange::kFriction, msgs::RemedyAmount::FRICTION));
static_assert(is_remedy(RemedyChange::kForce, msgs::RemedyAmount::FORCE));
static_assert(is_remedy(RemedyChange::kMass, msgs::RemedyAmount::MASS));
static_assert(is_remedy(RemedyChange::kMotors, msgs::RemedyAmount::MOTORS));
static_assert(is_remedy(RemedyChange::kAir, msgs::RemedyAmount::AIR));
static_assert(is_remedy(RemedyChange::kNeighbours, msgs::RemedyAmount::NEIGHBOURS));
static_assert(is_remedy(RemedyChange::kApproach, msgs::RemedyAmount::APPROACH));
static_assert(is_remedy(RemedyChange::kWorkspace, msgs::RemedyAmount::WORKSPACE));
static_assert(is_remedy(RemedyChange::kPlace, msgs::RemedyAmount::PLACE));
static_assert(is_remedy(RemedyChange::kPlace, msgs::RemedyAmount::Change_MAX),
              "a new one has none here");

}  // namespace

void add_remedies(const planning::Remedies& remedies, msgs::GraspPlan* plan) {
  for (const planning::Remedy& remedy : remedies.found) {
    msgs::Remedy& message = *plan->add_remedies();
    message.set_grasps(static_cast<std::uint32_t>(remedy.grasps));
    message.set_text(remedy.text);
    for (const planning::Remedy::Amount& amount : remedy.amounts) {
      msgs::RemedyAmount& one = *message.add_amounts();
      one.set_change(static_cast<msgs::RemedyAmount::Change>(amount.change));
      one.set_planned(amount.planned);
      one.set_needed(amount.needed);
    }
  }
  for (const std::string& one : remedies.in_vain) plan->add_remedies_in_vain(one);
  plan->set_remedies_incomplete(!remedies.complete);
}

}  // namespace prehend::convert
