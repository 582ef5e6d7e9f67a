#pragma once

#include <string>
#include <utility>
#include <vector>

#include "msgs/graph.pb.h"

namespace prehend::tools {

/// A YAML mapping of names to values with a comment on each, as `--params FILE` and `prehend param
/// load` read it.
std::string parameter_file_text(const std::string& node,
                                const std::vector<msgs::graph::ParameterRecord>& parameters);

/// Names and values of such a file; nested mappings join names with '.'. Throws std::runtime_error
/// with file and line.
std::vector<std::pair<std::string, std::string>> read_parameter_file(const std::string& file);

}  // namespace prehend::tools
