#pragma once

#include "nodes/report/collected.h"
#include "prehend/report/page.h"

namespace prehend::nodes {

/// The front that a budget or tolerance chose from, with the point chosen; nothing where none did,
/// or where a recording of before does not tell.
void add_fidelity(report::Page& page, const Collected& collected);

}  // namespace prehend::nodes
