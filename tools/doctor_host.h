#pragma once

#include "tools/finding.h"

namespace prehend::tools {

/// What of this machine and this user's environment a graph needs: open files, shared memory, the
/// folder for sockets.
Findings examine_host();

/// The registries that run on this machine, as "process 1234 (registry --endpoint ...)".
std::vector<std::string> living_registries();

}  // namespace prehend::tools
