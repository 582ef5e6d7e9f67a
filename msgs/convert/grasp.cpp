#include "msgs/convert/grasp.h"

#include <cmath>
#include <string>

#include "msgs/convert/geometry.h"
#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

void require_positive(double value, const std::string& name) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw geometry::InputError("A grasp whose " + name + " is not positive and finite",
                               kSenderMend);
  }
}

}  // namespace

msgs::PredictedPercepts to_message(const grasp::PredictedPercepts& predicted) {
  msgs::PredictedPercepts message;
  message.set_opening(predicted.opening);
  message.set_contact_area(predicted.contact_area);
  message.set_tactile_sum(predicted.tactile_sum);
  message.set_lifted_mass(predicted.lifted_mass);
  return message;
}

msgs::Grasp to_message(const grasp::Grasp& grasp) {
  msgs::Grasp message;
  *message.mutable_x_wg() = to_message(grasp.X_WG);
  *message.mutable_approach_direction() = to_message(grasp.approach_W);
  message.set_standoff(grasp.standoff);
  message.set_roll(grasp.roll);
  message.set_pregrasp_opening(grasp.pregrasp_opening);
  message.set_pregrasp_distance(grasp.pregrasp_distance);
  message.set_grasp_force(grasp.grasp_force);
  message.set_quality(grasp.quality);
  message.set_score(grasp.score);
  *message.mutable_predicted() = to_message(grasp.predicted);
  for (const auto& p_W : grasp.left_contacts_W) *message.add_left_contacts() = to_message(p_W);
  for (const auto& p_W : grasp.right_contacts_W) *message.add_right_contacts() = to_message(p_W);
  message.set_generator(grasp.generator);
  if (grasp.robustness >= 0) message.set_robustness(grasp.robustness);
  message.set_guessed_contact(grasp.guessed_contact);
  message.set_remark(grasp.remark);
  return message;
}

grasp::Grasp from_message(const msgs::Grasp& message) {
  grasp::Grasp grasp;
  grasp.X_WG = from_message(message.x_wg());
  grasp.approach_W = from_message(message.approach_direction());
  if (!(std::abs(grasp.approach_W.norm() - 1) < 1e-3)) {
    throw geometry::InputError("A grasp whose approach direction is not a unit vector",
                               kSenderMend);
  }
  require_positive(message.pregrasp_opening(), "pregrasp opening");
  require_positive(message.pregrasp_distance(), "pregrasp distance");
  require_positive(message.grasp_force(), "grasp force");
  grasp.standoff = message.standoff();
  grasp.roll = message.roll();
  grasp.pregrasp_opening = message.pregrasp_opening();
  grasp.pregrasp_distance = message.pregrasp_distance();
  grasp.grasp_force = message.grasp_force();
  grasp.quality = message.quality();
  grasp.score = message.score();
  grasp.predicted = {message.predicted().opening(), message.predicted().contact_area(),
                     message.predicted().tactile_sum(), message.predicted().lifted_mass()};
  grasp.generator = message.generator();
  grasp.robustness = message.has_robustness() ? message.robustness() : -1;
  grasp.guessed_contact = message.guessed_contact();
  grasp.remark = message.remark();
  for (const auto& p_W : message.left_contacts()) {
    grasp.left_contacts_W.push_back(from_message(p_W));
  }
  for (const auto& p_W : message.right_contacts()) {
    grasp.right_contacts_W.push_back(from_message(p_W));
  }
  return grasp;
}

void add_rejections(const std::vector<grasp::Rejection>& rejections, msgs::GraspPlan* plan) {
  for (const auto& rejected : rejections) {
    auto& rejection = *plan->add_rejections();
    rejection.set_reason(rejected.reason);
    rejection.set_count(static_cast<std::uint32_t>(rejected.count));
    rejection.set_generator(rejected.generator);
    rejection.set_nearest_miss(rejected.nearest_miss);
  }
}

msgs::GraspPlan to_message(const grasp::GraspPlanResult& plan) {
  msgs::GraspPlan message;
  for (const auto& grasp : plan.grasps) *message.add_grasps() = to_message(grasp);
  add_rejections(plan.rejections, &message);
  message.set_candidates(static_cast<std::uint32_t>(plan.candidates));
  message.set_problem(plan.problem);
  return message;
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
