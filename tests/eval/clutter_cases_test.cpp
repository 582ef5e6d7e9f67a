#include "eval/platform/clutter_cases.h"

#include <map>
#include <set>

#include <gtest/gtest.h>

#include "eval/household_objects.h"
#include "eval/platform/clear_run.h"
#include "eval/platform/graspable_bodies.h"
#include "prehend/control/task.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/triangle_mesh.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

TEST(ClutterCases, HaveEachCountAndKindAndLieWhereNothingIsPut) {
  const control::Task task = control::read_task("config/tasks/clear_table.yaml");
  std::map<std::string, int> kinds;
  std::set<int> counts;
  std::set<std::string> names;
  for (const ClutterCase& one : clutter_cases(84, 1)) {
    ++kinds[one.kind];
    counts.insert(one.options.count);
    names.insert(one.name);
    one.options.validate();
    // What rolls by as much as it may is not where the task puts things.
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        const Eigen::Vector2d corner =
            one.options.center + Eigen::Vector2d(x, y).cwiseProduct(one.options.size);
        EXPECT_FALSE(task.is_placed(corner)) << corner.transpose();
      }
    }
  }
  EXPECT_EQ(kinds.size(), 7u);
  for (const auto& [kind, count] : kinds) EXPECT_EQ(count, 12) << kind;
  EXPECT_EQ(counts.size(), 12u) << "one to twelve";
  EXPECT_EQ(names.size(), 84u);
}

TEST(ClutterSolids, AreThoseThatFitBetweenTheJaws) {
  std::vector<DataSet> sets = make_data_sets("household", household_objects());
  std::erase_if(sets, [](const DataSet& set) {
    return set.name != "can" && set.name != "milk_carton" && set.name != "bottle_lying";
  });
  const std::size_t all = clutter_solids(sets, 1).size();
  EXPECT_GE(all, 1u);
  EXPECT_THROW(clutter_solids(sets, 0.01), geometry::InputError);
  EXPECT_THROW(clutter_solids({}, 1), geometry::InputError);
}

TEST(GraspableBodies, AreThoseThatTheRobotGraspsWhenItKnowsThem) {
  const auto mesh = [](const Eigen::Vector3d& size) {
    return std::make_shared<geometry::TriangleMesh>(geometry::make_box(size));
  };
  const std::vector<simulation::ClutterSolid> solids{{"narrow", mesh({0.04, 0.05, 0.08}), 0.1},
                                                     {"wide", mesh({0.1, 0.12, 0.08}), 0.4}};
  std::vector<simulation::ClutterBody> bodies{{"narrow_0", 0}, {"wide_1", 1}};
  for (auto& body : bodies) body.X_WB.translation().z() = 0.04;
  bodies[1].X_WB.translation().x() = 0.005;  // they need not be apart: each is alone
  const auto robot = robot::read_platform("config/robots/stage_pg70.yaml");
  EXPECT_EQ(graspable_bodies(solids, bodies, robot), std::vector<std::string>{"narrow_0"});
}

TEST(ClearResult, IsTheSameWhenItIsReadAgain) {
  ClearResult result;
  result.scene = "scene_003_leaning";
  result.platform = "kr5_sdh";
  result.kind = "leaning";
  result.bodies = 6;
  result.cleared = 4;
  result.found = 5;
  result.attempts = 7;
  result.pushes = 2;
  result.neighbours = 1;
  result.simulated = 120.5;
  result.seconds = 33.25;
  result.ended = true;
  result.reason = "1 given up: grasp 0: \"it\"";
  result.left = {"can_1", "box_2"};
  result.graspable = {"can_1", "can_3"};
  result.failures = {{"shape", 2}};
  const ClearResult read = read_clear(to_text(result));
  EXPECT_EQ(read.scene, result.scene);
  EXPECT_EQ(read.platform, result.platform);
  EXPECT_EQ(read.kind, result.kind);
  EXPECT_EQ(read.bodies, result.bodies);
  EXPECT_EQ(read.cleared, result.cleared);
  EXPECT_EQ(read.found, result.found);
  EXPECT_EQ(read.attempts, result.attempts);
  EXPECT_EQ(read.pushes, result.pushes);
  EXPECT_EQ(read.neighbours, result.neighbours);
  EXPECT_EQ(read.simulated, result.simulated);
  EXPECT_EQ(read.seconds, result.seconds);
  EXPECT_EQ(read.ended, result.ended);
  EXPECT_EQ(read.reason, result.reason);
  EXPECT_EQ(read.left, result.left);
  EXPECT_EQ(read.graspable, result.graspable);
  EXPECT_EQ(read.graspable_cleared(), 1);
  EXPECT_EQ(read.failures, result.failures);
  EXPECT_EQ(read.said, result.said) << "none";
  EXPECT_NEAR(read.picks_an_hour(), 3600 * 4 / 120.5, 1e-9);
  EXPECT_THROW(read_clear(""), geometry::InputError);
}

TEST(ClearResult, KnowsTheCyclesWords) {
  EXPECT_EQ(cause_of("grasp 0: the fingers closed on nothing"), "shape");
  EXPECT_EQ(cause_of("grasp 3: touched something on the approach"), "shape");
  EXPECT_EQ(cause_of("grasp 1: lost while lifting: the fingers closed by 0.1 rad more"), "slip");
  EXPECT_EQ(cause_of("grasp 0: arm: lift: the arm hit something, the wrist felt 91 N"), "motion");
  EXPECT_EQ(cause_of("what nobody has said yet"), "other");
}

}  // namespace
}  // namespace prehend::eval
