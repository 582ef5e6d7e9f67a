#pragma once

#include <vector>

#include "msgs/grasp.pb.h"
#include "prehend/planning/decision.h"

namespace prehend::convert {

/// Adds what may be done with the object, best first.
void add_choices(const std::vector<planning::Choice>& choices, msgs::GraspPlan* plan);

}  // namespace prehend::convert
