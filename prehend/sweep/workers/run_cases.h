#pragma once

#include <cstdint>
#include <functional>

#include "prehend/sweep/handout.h"
#include "prehend/sweep/results.h"
#include "prehend/sweep/workers/workers.h"

namespace prehend::sweep {

struct RunProgress {
  std::int64_t total = 0, done = 0, failed = 0;  // of this run's cases; failed ones are not done
  int workers = 0;                               // that are there
  double seconds = 0;                            // since the start
  double working = 0;                            // s, of all cases that ended, together
  /// s: what workers had no case for, while there were some to be had, together.
  double waiting = 0;
  bool is_stopped = false;  // by the user, or because all workers are lost
};

/// Hands the cases to the workers and writes each result down at once. `order` says what a case is,
/// `say` hears how far it is about once a second.
RunProgress run_cases(Handout& handout, Workers& workers, ResultStore& store,
                      const std::function<CaseOrder(std::int64_t)>& order,
                      const std::function<void(const RunProgress&)>& say);

}  // namespace prehend::sweep
