#pragma once

#include "nodes/report/collected.h"
#include "prehend/report/page.h"

namespace prehend::nodes {

/// What was felt, where joints and gripper were, how high the objects were, over time.
void add_charts(report::Page& page, const Collected& collected);

}  // namespace prehend::nodes
