#pragma once

#include <filesystem>
#include <string>

#include "eval/case_runs.h"
#include "prehend/fidelity/chain_settings.h"

namespace prehend::eval {

/// What is swept, and where results go.
struct ChainSweep {
  fidelity::ChainInput input = fidelity::ChainInput::kImages;
  std::filesystem::path platform;  // its file
  CaseRunOptions runs;             // out: folder of the views' results and of the page
  std::filesystem::path front;     // file
  std::string machine;             // that it is measured on, in words
  bool quick = false;              // few chains and views; the front goes to `out`
};

/// Runs every chain of the grid on the views (those that are known already are not run again), says
/// how well chains are foretold by others, and writes the front, a table and a page.
/// @returns the process's exit status.
/// @throws geometry::InputError as PlatformUnderTest and run_cases().
int sweep_chains(const ChainSweep& sweep);

}  // namespace prehend::eval
