#include "eval/platform/table_scene.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "eval/household_objects.h"
#include "eval/platform/launched.h"
#include "eval/platform/pick_run.h"
#include "prehend/geometry/errors.h"
#include "prehend/simulation/world.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

std::vector<DataSet> household() {
  std::vector<DataSet> sets = make_data_sets("household", household_objects());
  std::erase_if(sets, [](const DataSet& set) {
    return set.name != "can" && set.name != "milk_carton" && set.name != "bottle_lying";
  });
  return sets;
}

TEST(TableScenes, BodiesStandApartOnTheTableAndAreTheSameAgain) {
  const std::vector<DataSet> sets = household();
  ASSERT_EQ(sets.size(), 3u);
  const auto scenes = make_table_scenes(sets, 8, 3);
  const auto again = make_table_scenes(sets, 8, 3);
  ASSERT_EQ(scenes.size(), 8u);
  std::set<std::size_t> counts;
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    counts.insert(scenes[s].bodies.size());
    ASSERT_EQ(again[s].bodies.size(), scenes[s].bodies.size());
    for (std::size_t i = 0; i < scenes[s].bodies.size(); ++i) {
      const PlacedBody& body = scenes[s].bodies[i];
      EXPECT_EQ(again[s].bodies[i].x, body.x);
      EXPECT_NEAR(geometry::bounds(*body.mesh_B).min().z(), 0, 1e-9);
      for (std::size_t k = 0; k < i; ++k) {
        const PlacedBody& other = scenes[s].bodies[k];
        const auto radius = [](const PlacedBody& b) {
          return geometry::bounds(*b.mesh_B).sizes().head<2>().norm() / 2;
        };
        EXPECT_GT(std::hypot(body.x - other.x, body.y - other.y),
                  radius(body) + radius(other) + 0.049);
      }
    }
  }
  EXPECT_GE(counts.size(), 3u) << "one to four";
}

TEST(TableScenes, AreScenesOfTheSimulationInWhichNothingFalls) {
  const testing::TemporaryFolder folder;
  const auto scenes = make_table_scenes(household(), 4, 5);
  simulation::World world(simulation::read_scene(write_scene(scenes.back(), folder.path)));
  ASSERT_EQ(world.body_count(), scenes.back().bodies.size());
  world.advance(1);
  for (std::size_t i = 0; i < world.body_count(); ++i) {
    const PlacedBody& body = scenes.back().bodies[i];
    const auto reading = world.body(body.name);
    EXPECT_NEAR(reading.X_WB.translation().x(), body.x, 0.003) << body.name;
    EXPECT_NEAR(reading.height, 0, 0.003) << body.name;
  }
}

TEST(TableScenes, NeedABodyThatStandsAlone) {
  std::vector<DataSet> sets = household();
  for (DataSet& set : sets) set.viewing.others_B.push_back(set.mesh_B);
  EXPECT_THROW(make_table_scenes(sets, 1, 1), geometry::InputError);
}

TEST(LaunchArguments, AreNamesWithValuesThatTheEvaluationDoesNotGive) {
  const std::vector<std::string> right{"minimum_stability:=0.1", "place:=0.1,-0.2", "a:=:="};
  EXPECT_EQ(launch_arguments(right), right);
  EXPECT_EQ(launch_arguments({}), std::vector<std::string>());
  for (const char* wrong : {"reacts", "", ":=1", "reacts=false", "speed:=1", "platform:=kr5_sdh"}) {
    EXPECT_THROW(launch_arguments({"reacts:=true", wrong}), geometry::InputError) << wrong;
  }
}

TEST(PickResults, AreReadAsTheyWereWritten) {
  PickResult result;
  result.scene = "scene_001";
  result.platform = "kr5_sdh";
  result.outcome = PickResult::Outcome::kFalseClaim;
  result.reason = "it: \"was\" moved\nand more";
  result.raised = 0.12345;
  const PickResult read = read_pick(to_text(result));
  EXPECT_EQ(read.outcome, result.outcome);
  EXPECT_EQ(read.reason, result.reason);
  EXPECT_EQ(read.raised, result.raised);
  EXPECT_THROW(read_pick(""), geometry::InputError);
}

}  // namespace
}  // namespace prehend::eval
