#pragma once

#include "tools/sweep/choices.h"

namespace prehend::tools {

/// Does what `prehend sweep` was asked for. Returns main()'s exit code: 0 when all that ran is
/// done, 1 when something failed, 130 when it was stopped. @throws std::exception for what is wrong
/// with the description, the folder, the program.
int run_sweep(const SweepChoices& choices);

}  // namespace prehend::tools
