#pragma once

#include <map>
#include <string>

namespace prehend::graph {

/// A value in a parameter file.
struct FileParameter {
  std::string text;
  int line = 0;  ///< from 1
};

/// Reads a YAML file of parameters: a mapping of names to single values; nested mappings join names
/// with '.'. Throws std::invalid_argument "FILE:LINE: what is wrong".
std::map<std::string, FileParameter> read_parameter_file(const std::string& file);

}  // namespace prehend::graph
