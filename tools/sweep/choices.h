#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// Options of `prehend sweep` and of the program that it becomes.
struct SweepChoices {
  std::string file, out;
  int workers = 0;  // 0: a processor each
  std::string only, again, costs;
  std::string part;  // "K/N"
  int slurm = 0;     // parts; 0: none
  std::string export_file, export_costs;
  bool merge = false, status = false, list = false;
  bool mpi = false;
  double lost_after = 30;  // s, of a rank's silence
};

/// `choices` lives as long as the app.
void add_sweep_options(CLI::App& app, SweepChoices& choices);

}  // namespace prehend::tools
