#include "nodes/stage_fidelity/asked_fidelity.h"

#include <cmath>

#include <fmt/format.h>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/geometry/errors.h"

namespace prehend::nodes {
namespace {

// Rounded up, so that what is written as it stands there is enough.
double rounded_up(double value) { return std::ceil(1e6 * value) / 1e6; }

}  // namespace

AskedFidelity asked_fidelity(const control::Task& task, double budget, double tolerance) {
  if (task.asked_at.empty()) return {budget, tolerance, ""};
  if (budget > 0 || tolerance > 0) {
    throw geometry::InputError(
        fmt::format("{} is given beside the parameter {}, of this or the launch file",
                    task.asked_at, budget > 0 ? "budget" : "tolerance"),
        "Leave one of them out");
  }
  return {task.budget, task.tolerance, task.asked_at};
}

fidelity::Front read_asked_front(const std::string& file, const AskedFidelity& asked) {
  const std::string by_task = asked.task_at.empty() ? "" : asked.task_at + ": ";
  if (file.empty()) {
    throw geometry::InputError(
        by_task + "Parameter front is empty, but a budget or tolerance is given",
        "Name a front like config/fidelity/chain.yaml");
  }
  fidelity::Front front = fidelity::read_front(file);
  if (!by_task.empty() && front.subject != "chain") {
    throw geometry::InputError(
        fmt::format("{}A task asks for whole chains, and the parameter front is one of '{}'",
                    by_task, front.subject),
        "Name a front like config/fidelity/chain.yaml");
  }
  return front;
}

const fidelity::Setting& choose_asked(const fidelity::Front& front, const AskedFidelity& asked) {
  try {
    return fidelity::choose_for_stage(front, asked.budget, asked.tolerance);
  } catch (const fidelity::UnreachableError& error) {
    if (asked.task_at.empty()) throw;
    const bool is_budget = asked.budget > 0;
    throw geometry::InputError(
        asked.task_at + ": " + error.problem(),
        fmt::format("Give at least {}, as the {} one has",
                    rounded_up(is_budget ? error.nearest().seconds
                                         : fidelity::tolerated_error(front, error.nearest())),
                    is_budget ? "fastest" : "most accurate"));
  }
}

}  // namespace prehend::nodes
