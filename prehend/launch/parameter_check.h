#pragma once

#include <map>
#include <string>
#include <vector>

#include "prehend/launch/launch_file.h"

namespace prehend::launch {

/// What is wrong with the parameters of a launch, and what else its programs say of themselves.
struct ParameterFindings {
  std::vector<std::string> errors;  ///< "FILE:LINE: ...", with the nearest match
  std::vector<std::string> notes;   ///< what could not be checked, and why
  /// [s] by executable: how long it may take to end, see graph::NodeDescription. Only of those that
  /// say so.
  std::map<std::string, double> stop_times;
};

/// Checks every parameter, in launch and parameter files, by name, type, range and choices against
/// what the programs declare, that files which nodes of `host` ("": a graph without hosts) are to
/// read are there, and that composed programs can be composed. Runs `PROGRAM --describe`
/// of each program once, all at the same time, for 10 s at most.
ParameterFindings check_parameters(const LaunchGraph& graph, const std::string& host = "");

}  // namespace prehend::launch
