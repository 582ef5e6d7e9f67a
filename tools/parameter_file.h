#pragma once

#include <string>
#include <vector>

#include "msgs/graph.pb.h"

namespace prehend::tools {

/// A YAML mapping of names to values with a comment on each, as `--params FILE` and `prehend param
/// load` read it.
std::string parameter_file_text(const std::string& node,
                                const std::vector<msgs::graph::ParameterRecord>& parameters);

}  // namespace prehend::tools
