#include "eval/grasp/chain_tradeoff.h"

#include <cmath>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "eval/household_objects.h"
#include "prehend/fidelity/chain_settings.h"
#include "prehend/geometry/errors.h"
#include "prehend/text/tree_file.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

using fidelity::ChainInput;
using fidelity::Stage;

ChainGrid small_grid(std::size_t seeing, std::size_t shape, std::size_t plan) {
  ChainGrid grid;
  for (std::size_t i = 0; i < seeing; ++i) {
    grid.seeing.push_back({{{"stereo", std::to_string(i)}}, 0, 0});
  }
  for (std::size_t i = 0; i < shape; ++i) {
    grid.shape.push_back({{{"spacing", std::to_string(i)}}, 0, 0});
  }
  for (std::size_t i = 0; i < plan; ++i) {
    grid.plan.push_back({{{"plan.rolls", std::to_string(i)}}, 0, 0});
  }
  return grid;
}

TEST(ChainGrid, HasEachSettingOfAStageWithEachOfTheOthers) {
  const ChainGrid grid = small_grid(2, 3, 4);
  ASSERT_EQ(grid.size(), 24u);
  EXPECT_EQ(to_string(grid.setting(0)), "seeing.stereo 0, shape.spacing 0, plan.rolls 0");
  EXPECT_EQ(to_string(grid.setting(1)), "seeing.stereo 0, shape.spacing 0, plan.rolls 1");
  EXPECT_EQ(to_string(grid.setting(23)), "seeing.stereo 1, shape.spacing 2, plan.rolls 3");
  EXPECT_EQ(grid.levels(13), (std::array<std::size_t, 3>{1, 0, 1}));
}

// Of which seeing is no part.
TEST(ChainGrid, OfACloudBeginsWithItsSegmentation) {
  ChainGrid grid = small_grid(0, 1, 1);
  grid.input = ChainInput::kCloud;
  grid.seeing = {{{{"clustering", "organized"}}, 0, 0}};
  EXPECT_EQ(to_string(grid.setting(0)),
            "segmentation.clustering organized, shape.spacing 0, plan.rolls 0");
  const ChainTrial trial{{0.01, 0.05, 0.04}, 0.002, true, true};
  const fidelity::Front front =
      chain_front(grid.input, measured_chains(grid, {{trial}}), "stage_pg70", "a test");
  ASSERT_EQ(front.settings.size(), 1u);
  const fidelity::Setting& setting = front.settings[0];
  EXPECT_EQ(fidelity::stage_seconds(setting, Stage::kSegmentation), 0.01);
  EXPECT_THROW(fidelity::stage_seconds(setting, Stage::kSeeing), geometry::InputError);
  EXPECT_EQ(fidelity::stage_setting(front, setting, Stage::kSegmentation).knobs,
            grid.seeing[0].knobs);
}

// One view that every chain lifts, one that only the second of two does, of which the first has no
// mesh.
TEST(MeasuredChains, AreMeansOfTheViews) {
  const ChainGrid grid = small_grid(1, 1, 2);
  const ChainTrial lifted{{0.1, 0.2, 0.3}, 0.002, true, true};
  const ChainTrial late{{0.3, 0.4, 0.7}, 0.004, true, true};
  const ChainTrial without{{0.3, 0.0, 0.0}, kUnknown, false, false};
  const std::vector<MeasuredChain> measured =
      measured_chains(grid, {{lifted, lifted}, {without, late}});
  ASSERT_EQ(measured.size(), 2u);
  EXPECT_EQ(measured[0].lifted, 1);
  EXPECT_EQ(measured[0].meshes, 1);
  EXPECT_EQ(measured[0].setting.error, 0.5);
  EXPECT_NEAR(measured[0].setting.seconds, 0.45, 1e-12);
  EXPECT_NEAR(measured[0].setting.other_errors[0].second, 0.002, 1e-12);
  EXPECT_NEAR(fidelity::stage_seconds(measured[1].setting, Stage::kShape), 0.3, 1e-12);
  EXPECT_NEAR(measured[1].setting.other_errors[0].second, 0.003, 1e-12);
  // The first is faster, but has no mesh of what the second has one of.
  const fidelity::Front front = chain_front(ChainInput::kImages, measured, "stage_pg70", "a test");
  ASSERT_EQ(front.settings.size(), 1u);
  EXPECT_EQ(front.settings[0].error, 0);
}

// What lifts no more but has better meshes is worth its time; what is beaten in all three is not.
TEST(ChainFront, KeepsBetterMeshesToo) {
  const ChainGrid grid = small_grid(1, 1, 4);
  const ChainTrial fast{{0.1, 0.1, 0.1}, 0.004, true, true};
  const ChainTrial fine{{0.1, 0.1, 0.2}, 0.002, true, true};
  const ChainTrial slow{{0.1, 0.1, 0.3}, 0.003, true, true};
  const ChainTrial worst{{0.1, 0.1, 0.4}, 0.002, true, false};
  const fidelity::Front front =
      chain_front(ChainInput::kImages, measured_chains(grid, {{fast, fine, slow, worst}}),
                  "stage_pg70", "a test");
  ASSERT_EQ(front.settings.size(), 2u);
  EXPECT_NEAR(front.settings[0].seconds, 0.3, 1e-12);
  EXPECT_NEAR(front.settings[1].other_errors[0].second, 0.002, 1e-12);
  const testing::TemporaryFolder folder;
  fidelity::write_front(folder.path / "chain.yaml", front);
  EXPECT_EQ(fidelity::read_front(folder.path / "chain.yaml").settings.size(), 2u);
}

// What depends on each setting alone, and of times on that before too, is foretold exactly.
TEST(Foretell, IsExactWithoutFurtherInteractions) {
  const ChainGrid grid = small_grid(3, 4, 4);
  std::vector<ChainTrial> view;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const auto [s, h, p] = grid.levels(i);
    ChainTrial trial;
    trial.seconds = {0.1 * static_cast<double>(1 + s),
                     0.05 * static_cast<double>((1 + s) * (1 + h)),
                     0.02 * static_cast<double>((1 + h) * (1 + p))};
    trial.mesh_error = 0.002 + 0.001 * static_cast<double>(s) + 0.0005 * static_cast<double>(h);
    trial.lifted = true;
    view.push_back(trial);
  }
  std::vector<MeasuredChain> measured = measured_chains(grid, {view});
  const Foretold exact = foretell(grid, measured);
  EXPECT_EQ(exact.chains, 12);
  EXPECT_LT(exact.worst_time, 1e-9);
  EXPECT_LT(exact.worst_mesh, 1e-9);
  EXPECT_LT(exact.worst_not_lifted, 1e-9);
  for (MeasuredChain& chain : measured) {
    if (chain.levels[0] == 0 && chain.levels[1] == 0 && chain.levels[2] == 0) {
      chain.setting.seconds *= 2;
    }
  }
  EXPECT_NEAR(foretell(grid, measured).worst_time, 0.5, 1e-9);
}

TEST(ChainTrials, AreReadAsTheyWereWritten) {
  const std::vector<ChainTrial> trials{{{0.1, 0.25, 0.5}, 0.002, true, false},
                                       {{0.1, 0, 0}, kUnknown, false, false}};
  const std::string text = to_text(trials);
  const std::vector<ChainTrial> read = read_chain_trials(text);
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].seconds, trials[0].seconds);
  EXPECT_EQ(read[0].mesh_error, 0.002);
  EXPECT_TRUE(read[0].planned);
  EXPECT_FALSE(read[0].lifted);
  EXPECT_TRUE(std::isnan(read[1].mesh_error));
  EXPECT_THROW(read_chain_trials(text.substr(0, 20)), geometry::InputError);
}

// The chain that ships, on a bottle seen from one side: it is seen, meshed to some millimetres, and
// lifted.
class RunChains : public ::testing::TestWithParam<ChainInput> {};

TEST_P(RunChains, LiftABottle) {
  std::vector<EvaluationObject> objects;
  for (const EvaluationObject& object : household_objects()) {
    if (object.name == "bottle") objects.push_back(object);
  }
  const std::vector<DataSet> sets = make_data_sets("household", objects);
  const PlatformUnderTest stage(text::tree_file("config/robots/stage_pg70.yaml"));
  ChainGrid grid = chain_grid(GetParam(), stage.hand(), false);
  grid.seeing = {grid.seeing.back()};
  grid.shape = {grid.shape.back()};
  grid.plan = {grid.plan.back()};
  const std::vector<ChainTrial> trials = run_chains({&sets.front(), 45, 1}, stage, grid);
  ASSERT_EQ(trials.size(), 1u);
  EXPECT_LT(trials[0].mesh_error, 0.005);
  EXPECT_TRUE(trials[0].planned);
  EXPECT_TRUE(trials[0].lifted);
  for (const double seconds : trials[0].seconds) EXPECT_GT(seconds, 0);
  if (GetParam() == ChainInput::kImages) return;
  EXPECT_LT(trials[0].seconds[0], 0.3) << "the pictures are not matched in it";
}

INSTANTIATE_TEST_SUITE_P(From, RunChains,
                         ::testing::Values(ChainInput::kImages, ChainInput::kCloud),
                         [](const auto& one) { return std::string(to_string(one.param)); });

}  // namespace
}  // namespace prehend::eval
