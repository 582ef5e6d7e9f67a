#pragma once

#include <string>
#include <vector>

#include "prehend/launch/launch_file.h"

namespace prehend::launch {

/// What is wrong with the parameters of a launch.
struct ParameterFindings {
  std::vector<std::string> errors;  ///< "FILE:LINE: ...", with the nearest match
  std::vector<std::string> notes;   ///< what could not be checked, and why
};

/// Checks every parameter, in launch and parameter files, by name, type, range and choices against
/// what the programs declare, and that composed programs can be composed. Runs `PROGRAM --describe`
/// of each program once, all at the same time, for 10 s at most.
ParameterFindings check_parameters(const LaunchGraph& graph);

}  // namespace prehend::launch
