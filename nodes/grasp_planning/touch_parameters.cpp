#include "nodes/grasp_planning/touch_parameters.h"

#include <map>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "nodes/touch_fidelity/touch_fidelity.h"
#include "prehend/fidelity/touch_settings.h"

namespace prehend::nodes {

double declare_grip_force(graph::Node& node) {
  return node.declare_parameter<double>(
      {.name = "grip_force",
       .default_value = 0.0,
       .unit = "N",
       .minimum = 0.0,
       .description = "of fingers with pads: that those which touch are to "
                      "feel, their mean; goes with the plan, and grasp_cycle presses so; 0: as the "
                      "motors press, or as grasp_cycle is told",
       .read_only = true});
}

void refuse_touch_parameters(const graph::Node& node, const robot::Platform& platform) {
  const robot::HandModel& hand = platform.hand;
  const auto refuse = [&](const char* name, const char* why) {
    if (!node.is_parameter_given(name)) return;
    throw std::invalid_argument(
        fmt::format("parameter '{}' does not apply with the hand '{}': {}; leave it out", name,
                    hand.name, why));
  };
  // The launch files give both, 0 where nothing is asked for.
  const auto refuse_choice = [&](const char* why) {
    for (const char* name : {"touch_budget", "touch_tolerance"}) {
      if (node.parameter<double>(name) > 0) refuse(name, why);
    }
  };
  if (hand.pads.empty()) {
    refuse("grip_force", "it has no tactile pads");
    refuse("predict_touch", "it has no tactile pads");
    refuse_choice("it has no tactile pads");
  }
  if (hand.gripper) refuse("grip_force", "its force is planned");
  if (platform.hand_port == robot::HandPort::kGripper) {
    refuse("predict_touch", "what its pads feel is what its grasps are planned by");
    refuse_choice("what its pads feel is what its grasps are planned by, without a simulation");
  }
}

TouchParameters declare_touch(graph::Node& node) {
  const bool predict = node.declare_parameter<bool>(
      {.name = "predict_touch",
       .default_value = true,
       .description = "close the hand in simulation, for the grasps that get a "
                      "motion, to tell what its pads should feel",
       .read_only = true});
  const fidelity::TouchRequest request =
      declare_touch_request(node, "touch_", "the hand that closes in simulation");
  if (!predict) {
    if (request.is_asked()) {
      throw std::invalid_argument(
          "touch_budget and touch_tolerance do not apply with predict_touch:=false; leave them "
          "out");
    }
    return {};
  }
  TouchParameters touch;
  touch.options.emplace();
  if (request.is_asked()) {
    const fidelity::ChosenTouch chosen =
        fidelity::choose_touch(request, fidelity::TouchWorld::kRobotWorld);
    touch.options->world.step = fidelity::touch_hand_step(chosen.setting);
    touch.chosen = chosen.setting;
    node.log_info("steps of predicted touch chosen: {}", chosen.text);
  }
  return touch;
}

void log_touch(graph::Node& node, const msgs::GraspPlan& plan) {
  for (const auto& time : plan.times()) {
    if (time.stage() != kTouchStage) continue;
    node.log_info("  touch of the grasps with a motion was simulated in {:.2f} s", time.seconds());
  }
  std::map<std::string, std::string> grasps;  // by the reason
  for (int i = 0; i < plan.grasps_size(); ++i) {
    const std::string& why = plan.grasps(i).predicted().not_predicted();
    if (!why.empty()) grasps[why] += (grasps[why].empty() ? "" : ", ") + std::to_string(i);
  }
  for (const auto& [why, which] : grasps) {
    node.log_info("  touch is not predicted of grasp {}: {}", which, why);
  }
}

}  // namespace prehend::nodes
