#include "nodes/report/fidelity_section.h"

#include "nodes/report/object_section.h"
#include "prehend/report/front_chart.h"

namespace prehend::nodes {
namespace {

// All stages choose the same setting of a chain: any object tells it.
const msgs::FidelityChoice* told_choice(const Collected& collected) {
  for (const auto& [id, model] : collected.models) {
    if (model.has_fidelity() && model.fidelity().front_size() > 0) return &model.fidelity();
  }
  for (const auto& [id, shape] : collected.shapes) {
    if (shape.has_fidelity() && shape.fidelity().front_size() > 0) return &shape.fidelity();
  }
  return nullptr;
}

}  // namespace

void add_fidelity(report::Page& page, const Collected& collected) {
  const msgs::FidelityChoice* choice = told_choice(collected);
  if (choice == nullptr) return;
  report::DrawnFront front;
  front.subject = choice->subject();
  front.error_name = choice->error_name();
  front.error_unit = choice->error_unit();
  for (const auto& point : choice->front()) {
    front.points.push_back({point.seconds(), point.error(), point.mesh()});
  }
  front.chosen = choice->chosen();
  front.budget = choice->budget();
  front.tolerance = choice->tolerance();
  front.asked_at = choice->asked_at();
  front.measured = choice->measured();
  front.knobs = choice->knobs();
  section(page, "Speed and accuracy", [&] { report::add_front(page, front); });
}

}  // namespace prehend::nodes
