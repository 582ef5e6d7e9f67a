#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// Options of `prehend calibrate tactile` and of the program that it becomes.
struct PadFitChoices {
  std::vector<std::string> logs, columns, checks;
  std::string out, report;
  int rows = 14, texel_columns = 6, full_scale = 4095, creep_terms = 1, hysteresis_terms = 1;
  double pitch = 0.0034;  // m
  bool json = false;
};

void add_pad_fit_options(CLI::App& command, PadFitChoices& choices);

}  // namespace prehend::tools
