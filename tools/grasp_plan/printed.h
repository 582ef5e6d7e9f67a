#pragma once

#include <string>

#include "tools/grasp_plan/planned.h"

namespace prehend::tools {

/// Tables of grasps, ledger, arm and stage times on standard output; or one JSON object.
void print_plan(const PlanChoices& choices, const PlanTarget& target, const Planned& planned);

/// Writes index.html with pictures of the best grasps and the tables into choices.out.
/// @throws std::runtime_error naming a file that cannot be written.
void write_plan_page(const PlanChoices& choices, const PlanTarget& target, const Planned& planned);

/// Writes the object's mesh and the plan into choices.save, made where it is not there.
/// @throws geometry::InputError, std::runtime_error naming a file that cannot be written.
void save_plan(const PlanChoices& choices, const PlanTarget& target, const Planned& planned);

}  // namespace prehend::tools
