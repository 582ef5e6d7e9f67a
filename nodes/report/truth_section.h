#pragma once

#include "nodes/report/collected.h"
#include "prehend/report/page.h"

namespace prehend::nodes {

/// Of each predicted object whose true surface a simulation says: both volumes, how far the true
/// surface is from the predicted one, and sections of both.
void add_truth(report::Page& page, const Collected& collected);

}  // namespace prehend::nodes
