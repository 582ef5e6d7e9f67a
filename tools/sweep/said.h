#pragma once

#include "prehend/sweep/cases.h"
#include "prehend/sweep/table.h"

namespace prehend::tools {

/// How many cases of the description are done, failed, open; then the failed ones with the last
/// lines that they printed. True when none failed and none is open.
bool print_status(const sweep::Cases& cases, const sweep::FindResult& find,
                  const std::string& command);

}  // namespace prehend::tools
