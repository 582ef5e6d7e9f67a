#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// Options of `prehend bag convert` and of the program that it becomes.
struct BagConvertChoices {
  std::string file, output, platform, robots, images = "jpeg", compression = "lz4";
  bool only_views = false;
};

void add_bag_convert_options(CLI::App& command, BagConvertChoices& choices);

}  // namespace prehend::tools
