#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/grasp/chain_trial.h"

namespace prehend::eval {

/// One chain over all views.
struct MeasuredChain {
  fidelity::Setting setting;  // mean time; share of views not lifted at the first attempt; the mean
                              // error of the meshes [m], and the mean time of each stage [s]
  std::array<std::size_t, 3> levels{};  // of its stages, in the grid
  int lifted = 0, meshes = 0, views = 0;
};

/// Means over the views, of which there is a list of trials each.
std::vector<MeasuredChain> measured_chains(const ChainGrid& grid,
                                           const std::vector<std::vector<ChainTrial>>& views);

/// The front, of time, of what is not lifted and of the meshes' error, of the chains that gave a
/// mesh of as many views as the best of them.
fidelity::Front chain_front(fidelity::ChainInput input, const std::vector<MeasuredChain>& measured,
                            const std::string& platform, const std::string& machine);

/// How well chains are foretold that nobody measured: a quarter of them is left out, and said by
/// the others. A stage's time is the product of what each setting makes of it and each two settings
/// of two stages of the rest; errors are the sum of what each setting changes of the mean.
struct Foretold {
  int chains = 0;
  double worst_time = 0, mean_time = 0;              // share of the measured
  double worst_mesh = 0, mean_mesh = 0;              // share of the measured
  double worst_not_lifted = 0, mean_not_lifted = 0;  // of the views, difference
};
Foretold foretell(const ChainGrid& grid, const std::vector<MeasuredChain>& measured);

}  // namespace prehend::eval
