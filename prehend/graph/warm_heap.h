#pragma once

namespace prehend::graph {

/// Large messages come and go all the time: from here on the process keeps their memory instead of
/// giving it back and paying for page faults again.
void keep_heap_warm();

}  // namespace prehend::graph
