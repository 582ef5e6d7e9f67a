#pragma once

#include "msgs/grasp.pb.h"
#include "prehend/planning/remedies.h"

namespace prehend::convert {

/// Adds what would help, and what would not, to a plan without grasps.
void add_remedies(const planning::Remedies& remedies, msgs::GraspPlan* plan);

}  // namespace prehend::convert
