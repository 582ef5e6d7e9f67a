#include "nodes/shape_fidelity/shape_fidelity.h"

#include <string>

#include "msgs/convert/fidelity.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {
namespace {

ChosenShape choose(const std::string& file, double budget, double tolerance) {
  if (file.empty()) {
    throw geometry::InputError("Parameter front is empty, but a budget or tolerance is given",
                               "Name a front like config/fidelity/shape.yaml");
  }
  const fidelity::Front front = fidelity::read_front(file);
  const fidelity::Setting& setting = fidelity::choose(front, budget, tolerance);
  ChosenShape chosen;
  chosen.options = fidelity::shape_options(setting);
  chosen.choice = convert::to_message(setting);
  return chosen;
}

}  // namespace

ShapeFidelity::ShapeFidelity(graph::Node& node) {
  const auto file = node.declare_parameter<std::string>(
      {.name = "front",
       .default_value = "",
       .description = "measured speed-accuracy front (config/fidelity/shape.yaml) to choose the "
                      "knobs from by budget or tolerance",
       .read_only = true,
       .reads_file = true});
  const auto budget = node.declare_parameter<double>(
      {.name = "budget",
       .default_value = 0.0,
       .unit = "s",
       .minimum = 0.0,
       .description = "from segmented cloud to mesh: the most accurate setting of the front that "
                      "takes no longer; 0: none asked for. At the start only",
       .read_only = true});
  const auto tolerance = node.declare_parameter<double>(
      {.name = "tolerance",
       .default_value = 0.0,
       .unit = "m",
       .minimum = 0.0,
       .description = "mean error of the mesh: the fastest setting of the front that keeps it; 0: "
                      "none asked for. At the start only",
       .read_only = true});
  if (budget == 0 && tolerance == 0) return;
  try {
    chosen_ = choose(file, budget, tolerance);
    const msgs::FidelityChoice& choice = chosen_->choice;
    node.log_info("chosen from {}: {} ({:.1f} ms, {:.2f} mm)", file, choice.knobs(),
                  1e3 * choice.seconds(), 1e3 * choice.error());
  } catch (const geometry::InputError& error) {
    problem_ = error;
    node.report(graph::Health::kError, error.what());
  }
}

const std::optional<ChosenShape>& ShapeFidelity::chosen() const {
  if (problem_) throw *problem_;
  return chosen_;
}

}  // namespace prehend::nodes
