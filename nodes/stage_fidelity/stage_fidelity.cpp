#include "nodes/stage_fidelity/stage_fidelity.h"

#include <utility>

#include "msgs/convert/fidelity.h"
#include "nodes/stage_fidelity/asked_fidelity.h"
#include "nodes/task_source/task_source.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {
namespace {

ChosenStage choose(const std::string& file, fidelity::Stage stage, const AskedFidelity& asked) {
  const fidelity::Front front = read_asked_front(file, asked);
  const fidelity::Setting& setting = choose_asked(front, asked);
  msgs::FidelityChoice choice =
      convert::to_message(front, setting, fidelity::measured_text(front, setting));
  choice.set_budget(asked.budget);
  choice.set_tolerance(asked.tolerance);
  choice.set_asked_at(asked.task_at);
  return {fidelity::stage_setting(front, setting, stage), std::move(choice)};
}

void refuse_beside_front(const graph::Node& node, const std::vector<std::string>& chosen_by_front) {
  for (const std::string& name : chosen_by_front) {
    if (!node.is_parameter_given(name)) continue;
    throw geometry::InputError(
        "Parameter " + name + " is chosen by the front where a budget or tolerance is given",
        "Leave it away, or budget and tolerance");
  }
}

}  // namespace

StageFidelity::StageFidelity(graph::Node& node, fidelity::Stage stage,
                             const std::vector<std::string>& chosen_by_front) {
  const auto file = node.declare_parameter<std::string>(
      {.name = "front",
       .default_value = "",
       .description = "measured speed-accuracy front to choose the knobs from by budget or "
                      "tolerance: of the whole chain (config/fidelity/chain.yaml), or of this "
                      "stage (shape.yaml there)",
       .read_only = true,
       .reads_file = true});
  const auto budget = node.declare_parameter<double>(
      {.name = "budget",
       .default_value = 0.0,
       .unit = "s",
       .minimum = 0.0,
       .description = "for what the front measured, the chain from images to grasps or the stage: "
                      "the most accurate setting that takes no longer; 0: none asked for. At the "
                      "start only",
       .read_only = true});
  const auto tolerance = node.declare_parameter<double>(
      {.name = "tolerance",
       .default_value = 0.0,
       .unit = "m",
       .minimum = 0.0,
       .description = "mean error of the mesh: the fastest setting of the front that keeps it; 0: "
                      "none asked for. At the start only",
       .read_only = true});
  const AskedFidelity asked = asked_fidelity(declare_task(node), budget, tolerance);
  if (!asked.is_asked()) return;
  refuse_beside_front(node, chosen_by_front);
  try {
    chosen_ = choose(file, stage, asked);
    node.log_info("chosen from {}: {} ({})", file, to_string(chosen_->setting),
                  chosen_->choice.measured());
  } catch (const geometry::InputError& error) {
    // The task is the whole graph's: it does not begin with one that cannot be done.
    if (!asked.task_at.empty()) throw;
    problem_ = error;
    node.report(graph::Health::kError, error.what());
  }
}

const std::optional<ChosenStage>& StageFidelity::chosen() const {
  if (problem_) throw *problem_;
  return chosen_;
}

}  // namespace prehend::nodes
