#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "prehend/simulation/clutter.h"

namespace prehend::tools {

/// Options of `prehend clutter` and of the program that it becomes.
struct ClutterChoices {
  std::string meshes, out;
  std::vector<double> center, size;  // m, two each; empty: the default
  double scale = 1, varied = 0;
  int scenes = 1;
  bool overwrite = false;
  simulation::ClutterOptions options;
};

/// `choices` lives as long as the app.
void add_clutter_options(CLI::App& app, ClutterChoices& choices);

}  // namespace prehend::tools
