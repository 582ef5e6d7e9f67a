#pragma once

#include <string>
#include <vector>

#include "prehend/report/page.h"

namespace prehend::report {

/// How many candidates fell at one stage of planning.
struct Rejected {
  std::string reason;  // in words
  std::string group;   // what they came from, e.g. their generator; may be empty
  int count = 0;
  std::string nearest_miss;  // how near the best of them came, in words; may be empty
};

/// Adds a bar for each reason, stacked of its groups, and a table with the nearest misses; in the
/// order given. `candidates`: all there were, `what` they are, e.g. "candidates". Without gnuplot
/// the table is there, and a sentence says why the bars are not. Adds nothing without rejections.
void add_rejections(Page& page, const std::vector<Rejected>& rejections, int candidates,
                    const std::string& what);

}  // namespace prehend::report
