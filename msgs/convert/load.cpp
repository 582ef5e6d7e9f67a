#include "msgs/convert/load.h"

#include <cmath>
#include <optional>
#include <string>

#include "msgs/convert/load_bounds.h"
#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

double read_load(double value, const char* what) {
  if (std::isfinite(value) && value >= 0) return value;
  throw geometry::InputError(
      std::string("Evidence of a load with ") + what + " of " + std::to_string(value), kSenderMend);
}

}  // namespace

msgs::LoadEvidence to_message(const belief::LoadEvidence& load) {
  msgs::LoadEvidence message;
  if (load.weight) message.set_weight(*load.weight);
  message.set_weight_deviation(load.weight_deviation);
  if (load.held_share) message.set_held_share(*load.held_share);
  if (load.slipped_share) message.set_slipped_share(*load.slipped_share);
  if (load.borne) message.set_borne(*load.borne);
  return message;
}

belief::LoadEvidence from_message(const msgs::LoadEvidence& message) {
  belief::LoadEvidence load;
  if (message.has_weight()) load.weight = read_load(message.weight(), "a weight");
  load.weight_deviation = read_load(message.weight_deviation(), "a weight's deviation");
  if (message.has_held_share()) load.held_share = read_load(message.held_share(), "a share held");
  if (message.has_slipped_share()) {
    load.slipped_share = read_load(message.slipped_share(), "a share that slipped");
  }
  if (message.has_borne()) load.borne = read_load(message.borne(), "a force borne");
  return load;
}

void set_load(const grasp::LoadBounds& load, msgs::ObjectModel* model) {
  if (load.mass.is_known()) *model->mutable_mass() = to_message(load.mass);
  if (load.friction.is_known()) *model->mutable_friction() = to_message(load.friction);
}

void set_load(const grasp::LoadBounds& load, msgs::Belief* belief) {
  if (load.mass.is_known()) *belief->mutable_mass() = to_message(load.mass);
  if (load.friction.is_known()) *belief->mutable_friction() = to_message(load.friction);
}

}  // namespace prehend::convert
