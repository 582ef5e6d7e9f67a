#pragma once

#include "prehend/sweep/cases.h"
#include "prehend/sweep/table.h"
#include "tools/sweep/run_cases.h"

namespace prehend::tools {

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

/// How many cases of the description are done, failed, open; then the failed ones with the last
/// lines that they printed. True when none failed and none is open.
bool print_status(const sweep::Cases& cases, const sweep::FindResult& find,
                  const std::string& command);

}  // namespace prehend::tools
