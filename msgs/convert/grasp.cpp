#include "msgs/convert/grasp.h"

#include <string>

#include "msgs/convert/geometry.h"
#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
msgs::PredictedPercepts to_message(const grasp::PredictedPercepts& predicted) {
  msgs::PredictedPercepts message;
  message.set_opening(predicted.opening);
  message.set_contact_area(predicted.contact_area);
  message.set_tactile_sum(predicted.tactile_sum);
  message.set_lifted_mass(predicted.lifted_mass);
  return message;
}

msgs::Grasp to_message(const grasp::Grasp& grasp, const robot::HandModel& hand) {
  msgs::Grasp message;
  *message.mutable_x_wg() = to_message(grasp.X_WG);
  *message.mutable_approach_direction() = to_message(grasp.approach_W);
  message.set_standoff(grasp.standoff);
  message.set_roll(grasp.roll);
  if (hand.gripper) message.set_pregrasp_opening(grasp::pregrasp_opening(grasp));
  message.set_pregrasp_distance(grasp.pregrasp_distance);
  message.set_grasp_force(grasp.force);
  message.set_quality(grasp.quality);
  message.set_score(grasp.score);
  *message.mutable_predicted() = to_message(grasp.predicted);
  message.set_preshape(grasp.preshape);
  for (const auto& p_W : grasp::contact_points(grasp)) *message.add_contacts() = to_message(p_W);
  message.set_generator(grasp.generator);
  if (grasp.robustness >= 0) message.set_robustness(grasp.robustness);
  message.set_guessed_contact(grasp.guessed_contact);
  message.set_remark(grasp.remark);
  return message;
}

void add_rejections(const std::vector<grasp::Rejection>& rejections, msgs::GraspPlan* plan) {
  for (const auto& rejected : rejections) {
    auto& rejection = *plan->add_rejections();
    rejection.set_reason(to_string(rejected.reason));
    rejection.set_count(static_cast<std::uint32_t>(rejected.count));
    rejection.set_generator(rejected.generator);
    rejection.set_nearest_miss(rejected.nearest_miss);
  }
}

msgs::KnownObject to_message(const grasp::Recognition& recognition) {
  msgs::KnownObject message;
  message.set_name(recognition.name);
  message.set_hash(recognition.hash);
  *message.mutable_x_wo() = to_message(recognition.X_WO);
  message.set_explained(recognition.explained);
  message.set_violated(recognition.violated);
  message.set_residual(recognition.residual);
  return message;
}

grasp::PlacedObject from_message(const msgs::KnownObject& message) {
  if (message.hash().empty()) {
    throw geometry::InputError("A known object without its mesh's hash", kSenderMend);
  }
  return {message.hash(), message.name(), from_message(message.x_wo())};
}

}  // namespace prehend::convert
