#pragma once

#include "prehend/sweep/workers/run_cases.h"

namespace prehend::sweep {

/// Prints how far a run is: over the line before on a terminal, else now and then.
class SaidProgress {
 public:
  void say(const RunProgress& progress);
  /// Clears the line.
  void end() const;

 private:
  double last_ = 0;
};

/// What a run did, and what handing out cost.
void print_summary(const RunProgress& progress);

}  // namespace prehend::sweep
