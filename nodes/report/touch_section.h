#pragma once

#include <string>

#include "nodes/report/collected.h"
#include "prehend/report/page.h"

namespace prehend::nodes {

/// "finger_1_distal" as people write it.
std::string in_words(std::string name);

/// What each pad felt at the end of the cycle's phases, beside what it was predicted to feel in the
/// grasp that was executed last; why that was not predicted, if so.
void add_touch(report::Page& page, const Collected& collected);

}  // namespace prehend::nodes
