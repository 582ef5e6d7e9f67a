#pragma once

#include "nodes/report/collected.h"
#include "prehend/report/page.h"

namespace prehend::nodes {

/// Of each attempt: how surprising what it perceived was, in bits by sense, and what its pads felt
/// beside the likeliest of what they were to feel.
void add_surprises(report::Page& page, const Collected& collected);

}  // namespace prehend::nodes
