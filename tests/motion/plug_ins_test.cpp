// Planners and checkers of another project (prehend/motion/example), loaded at run time.

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/motion/checker_registry.h"
#include "prehend/motion/plan_path.h"
#include "prehend/motion/planner_registry.h"
#include "prehend/motion/robot_in_world.h"
#include "tests/motion/shelves.h"

namespace prehend::motion {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const std::vector<std::filesystem::path> kExample{PREHEND_MOTION_EXAMPLE};

template <class Call>
std::string refusal_of(Call call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(PlugIns, OfAnotherProjectPlan) {
  const PlannerRegistry planners(kExample);
  const CheckerRegistry checkers(kExample);
  EXPECT_THAT(planners.names(), Contains("one_stop"));
  EXPECT_THAT(checkers.names(), Contains("turned_boxes"));
  // What ships is not lost, nor is it replaced.
  EXPECT_THAT(planners.names(), AllOf(Contains("rrt_connect"), Contains("ompl_rrt_connect")));
  EXPECT_THAT(checkers.names(), AllOf(Contains("balls"), Contains("fcl"), Contains("bullet")));

  const Shelves shelves;
  RobotInWorld robot = shelves.in_world();
  robot.use_checker(checkers.create("turned_boxes"),
                    make_robot_shapes(shelves.model, "base_link", "tool0"));
  RobotInWorld by_fcl = shelves.in_world();
  by_fcl.use_checker(checkers.create("fcl"),
                     make_robot_shapes(shelves.model, "base_link", "tool0"));
  std::mt19937_64 random(2);
  int free = 0;
  for (int i = 0; i < 1000; ++i) {
    const robot::Positions q = robot::random_positions(shelves.chain, random);
    free += robot.is_free(q);
    EXPECT_LE(robot.is_free(q), by_fcl.is_free(q)) << by_fcl.problem(q);
  }
  EXPECT_GT(free, 100);
  robot::Positions start = robot::Positions::Zero(7), goal = start;
  goal[0] = 1;
  const JointPath path = plan_path(*planners.create("one_stop"), robot, start, {goal});
  ASSERT_TRUE(path.found()) << path.reason;
  EXPECT_EQ(path.waypoints.size(), 2u);  // the stop in between was dropped
}

TEST(PlugIns, AreLookedForWhereTheEnvironmentSays) {
  ASSERT_EQ(setenv("PREHEND_PLANNERS", PREHEND_MOTION_EXAMPLE, 1), 0);
  EXPECT_THAT(PlannerRegistry().names(), Contains("one_stop"));
  unsetenv("PREHEND_PLANNERS");
  EXPECT_THAT(PlannerRegistry().names(), Not(Contains("one_stop")));
}

TEST(PlugIns, ThatCannotBeUsedAreNamed) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "prehend_plug_ins_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "broken.so") << "no library";
  // The folder of both: a checker is no planner.
  const PlannerRegistry planners({folder, kExample.front()});
  EXPECT_EQ(planners.problems().size(), 2u);
  const std::string said = refusal_of([&] { planners.create("one_step"); });
  EXPECT_THAT(said, AllOf(HasSubstr("no planner 'one_step'"), HasSubstr("nearest is 'one_stop'"),
                          HasSubstr("broken.so cannot be used"),
                          HasSubstr("turned_boxes.so cannot be used: exports no "
                                    "prehend_planner_interface")));
  // The same name twice.
  const CheckerRegistry twice({kExample.front(), kExample.front()});
  EXPECT_THAT(twice.problems().back().reason, HasSubstr("'turned_boxes' is taken"));
  std::filesystem::remove_all(folder);
}

TEST(PlugIns, AnUnknownNameSaysWhatThereIs) {
  const CheckerRegistry none(std::vector<std::filesystem::path>{"/nowhere"});
  EXPECT_THAT(none.problems(), IsEmpty());
  EXPECT_EQ(none.create("balls"), nullptr);
  EXPECT_THAT(refusal_of([&] { none.create("bulet"); }),
              AllOf(HasSubstr("nearest is 'bullet'"), HasSubstr("balls, bullet, fcl")));
  EXPECT_THAT(refusal_of([&] { none.create(""); }), HasSubstr("there are balls, bullet, fcl"));
}

}  // namespace
}  // namespace prehend::motion
