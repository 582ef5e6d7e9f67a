#pragma once

#include "bench/graph/worker_pair.h"

namespace prehend::bench {

/// The part of a job that this process plays; writes its figures to stdout. Throws what fails.
void run_worker(const WorkerCommand& command);

}  // namespace prehend::bench
