#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// Options of `prehend bag import` and of the program that it becomes.
struct BagImportChoices {
  std::string file, output, compression = "lz4";
  std::vector<std::string> topics;
  std::vector<std::string> stereo;  // left, right
  std::string depth, color;
};

void add_bag_import_options(CLI::App& command, BagImportChoices& choices);

}  // namespace prehend::tools
