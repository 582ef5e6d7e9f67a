#include "nodes/grasp_planning/misfit_parameters.h"

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "prehend/fidelity/chosen_chain.h"
#include "prehend/grasp/planner_options.h"
#include "prehend/planning/decision.h"
#include "prehend/planning/held_views.h"

namespace prehend::nodes {
namespace {

void refuse(const std::string& parameter, const std::string& with, const std::string& why) {
  throw std::invalid_argument("parameter '" + parameter + "' does not apply " + with + ": " + why +
                              "; leave it out");
}

void check(const graph::Node& node, const std::vector<std::string>& misfits,
           const std::string& with, const std::string& why) {
  for (const std::string& misfit : misfits) {
    if (node.is_parameter_given(misfit)) refuse(misfit, with, why);
  }
}

}  // namespace

void refuse_what_does_not_apply(const graph::Node& node, const robot::Platform& platform,
                                const fidelity::Front* front) {
  std::vector<std::string> misfits;
  const text::ListKnobs list{"", &misfits};
  if (platform.hand.gripper) {
    grasp::FingerOptions fingers;
    grasp::FingerOptions::knobs(fingers, list);
    check(node, misfits, "with a parallel gripper", "it is of hands with fingers");
  } else {
    const auto file = node.parameter<std::string>("front");
    if (!file.empty() && fidelity::read_front(file).subject != "chain") {
      refuse("front", "with a hand of fingers", "it was measured with the parallel gripper");
    }
    grasp::PadOptions pads;
    grasp::PadOptions::knobs(pads, list);
    check(node, misfits, "with a hand of fingers",
          "the hand's model has its friction, and its motors set the force");
  }
  if (front == nullptr) return;
  check(node, {"rolls", "standoffs", "robustness_samples"}, "beside a budget",
        "front and budget choose it");
  for (const auto& [parameter, knob] :
       {std::pair("motions", "motion.grasps"), std::pair("predict_touch", "simulation.step"),
        std::pair("largest_count", "plan.count"), std::pair("enough_grasps", "plan.enough"),
        std::pair("first_share", "plan.first_share")}) {
    if (!fidelity::has_knob(*front, knob)) continue;
    check(node, {parameter}, "beside a budget of the whole chain", "front and budget choose it");
  }
  if (!node.parameter<std::vector<std::string>>("generators").empty()) {
    refuse("generators", "beside a budget", "front and budget choose them");
  }
}

void refuse_views(const graph::Node& node, const control::Task& task,
                  const robot::Platform& platform) {
  const std::string with_task = "with task " + task.name;
  if (!task.does(control::Primitive::kInspect)) {
    std::vector<std::string> held;
    planning::HeldViewOptions options;
    planning::HeldViewOptions::knobs(options, text::ListKnobs{"held_view_", &held});
    check(node, held, with_task, "it does not look at what is held, as inspect does");
  }
  std::vector<std::string> looks;
  planning::ViewOptions options;
  planning::ViewOptions::knobs(options, text::ListKnobs{"look_", &looks});
  if (!task.does(control::Primitive::kDecide) && !task.does(control::Primitive::kView)) {
    check(node, looks, with_task, "it does not look from elsewhere, as look_and_pick does");
  }
  if (platform.X_FC) return;
  planning::DecisionOptions decision;
  planning::DecisionOptions::look_knobs(decision, text::ListKnobs{"decide_", &looks});
  check(node, looks, "with platform " + platform.name,
        "its arm carries no camera, as that of kr5_sdh_camera does");
}

}  // namespace prehend::nodes
