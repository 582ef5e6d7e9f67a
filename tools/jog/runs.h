#pragma once

#include "tools/jog/choices.h"

namespace prehend::tools {

/// Each does a command and returns its exit code. @throws std::exception with one line that says
/// what could not be done.
int run_jog(const JogChoices& choices);
int run_home(const JogChoices& choices);
int run_hand(const JogChoices& choices);

}  // namespace prehend::tools
