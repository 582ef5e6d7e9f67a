#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/data_sets.h"
#include "eval/grasp/platform_under_test.h"
#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/front.h"

// The whole chain on one view: images or their cloud, objects, shape, plan, lift.
namespace prehend::eval {

/// Which chains are measured: each setting of one stage with each of the others.
struct ChainGrid {
  fidelity::ChainInput input = fidelity::ChainInput::kImages;
  /// With the stages' own knobs, of first_stage(input) and of shape; of plan those of planning,
  /// motion and simulation with their stages' names.
  std::vector<fidelity::Setting> seeing, shape, plan;

  std::size_t size() const { return seeing.size() * shape.size() * plan.size(); }
  /// Of the chain's stages, by the index of the chain: plan changes fastest.
  std::array<std::size_t, 3> levels(std::size_t chain) const;
  /// Its knobs with their stages' names.
  fidelity::Setting setting(std::size_t chain) const;
};

/// The chains that are measured for the front; `quick`: a few of them, by two ways to
/// see and two to complete.
ChainGrid chain_grid(fidelity::ChainInput input, const robot::HandModel& hand, bool quick);

/// What one chain made of one view.
struct ChainTrial {
  std::array<double, 3> seconds{};  // of processor, of the grid's stages: seeing or segmentation,
                                    // shape, plan; 0: it did not come to that
  double mesh_error = kUnknown;     // m, mean distance of the true surface to the mesh
  bool planned = false;             // there is a grasp that the arm can execute
  bool lifted = false;              // at the first attempt, carried, and put down
};

/// Renders the view's pair once and runs each chain of the grid on it, or on the cloud that the
/// defaults see in it, which nobody's time counts; what stages share is computed once, and its time
/// counts for each. What fails is a trial that has not lifted.
std::vector<ChainTrial> run_chains(const Case& one, const PlatformUnderTest& platform,
                                   const ChainGrid& grid);

/// As YAML, and back. @throws geometry::InputError for a text that is no result.
std::string to_text(const std::vector<ChainTrial>& trials);
std::vector<ChainTrial> read_chain_trials(const std::string& text);

}  // namespace prehend::eval
