#pragma once

#include "tools/finding.h"
#include "tools/graph_view.h"

namespace prehend::tools {

/// What is wrong in a graph: nodes that are stale, in error or not ready; topics without
/// publishers, of several types, of QoS that does not fit, with losses; names offered twice; a
/// clock that nobody drives.
Findings examine_graph(const GraphView& graph);

}  // namespace prehend::tools
