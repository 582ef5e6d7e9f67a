// Paths in joint space.

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/motion/rrt_connect.h"
#include "tests/motion/shelves.h"
#include "tests/oracles/ompl_planner.h"
#include "tests/robot/arms.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using robot::Positions;
using ::testing::HasSubstr;

/// Whether a link's own shape is in an obstacle somewhere on the path, 5 mrad at a time.
bool collides(const Shelves& shelves, const JointPath& path) {
  for (std::size_t i = 1; i < path.waypoints.size(); ++i) {
    const Positions way = path.waypoints[i] - path.waypoints[i - 1];
    const int steps = 1 + static_cast<int>(way.norm() / 0.005);
    for (int k = 0; k <= steps; ++k) {
      const Positions q = path.waypoints[i - 1] + way * (static_cast<double>(k) / steps);
      if (shelves.oracle.collides(shelves.chain, q) || !shelves.chain.within_limits(q)) return true;
    }
  }
  return false;
}

TEST(PlanPath, GoesFromOneCompartmentToTheOtherWithoutTouching) {
  const Shelves shelves;
  const RobotInWorld robot = shelves.in_world();
  const auto left = shelves.reach(robot, {0.65, 0.22, 0.5});
  const auto right = shelves.reach(robot, {0.65, -0.22, 0.5});
  ASSERT_FALSE(left.empty());
  ASSERT_FALSE(right.empty());
  const JointPath path = plan_path(robot, left.front(), right);
  ASSERT_TRUE(path.found()) << path.reason;
  EXPECT_GT(path.iterations, 0);  // no straight line
  EXPECT_EQ(path.waypoints.front(), left.front());
  ASSERT_GE(path.goal, 0);
  EXPECT_EQ(path.waypoints.back(), right[static_cast<std::size_t>(path.goal)]);
  EXPECT_FALSE(collides(shelves, path));  // far more densely, with the links' own shapes
  // Same seed, same path; shortcuts do not lengthen it.
  const JointPath again = plan_path(robot, left.front(), right);
  ASSERT_EQ(again.waypoints.size(), path.waypoints.size());
  for (std::size_t i = 0; i < path.waypoints.size(); ++i) {
    EXPECT_EQ(again.waypoints[i], path.waypoints[i]);
  }
  RrtOptions plain;
  plain.shortcuts = 0;
  EXPECT_LE(path.length(), plan_path(robot, left.front(), right, plain).length());
}

TEST(PlanPath, TriesTheStraightLineToTheNearestGoalFirst) {
  const Shelves shelves;
  const RobotInWorld robot = shelves.in_world();
  const Positions start = Positions::Zero(7);
  Positions near = start, far = start;
  near[0] = 0.5;
  far[0] = -2;
  const JointPath path = plan_path(robot, start, {far, near});
  ASSERT_TRUE(path.found());
  EXPECT_EQ(path.goal, 1);
  EXPECT_EQ(path.iterations, 0);
  EXPECT_EQ(path.waypoints.size(), 2u);
  EXPECT_NEAR(path.length(), 0.5, 1e-12);
  const JointPath nowhere = plan_path(robot, start, {start});
  EXPECT_TRUE(nowhere.found());
  EXPECT_EQ(nowhere.length(), 0);
}

TEST(PlanPath, SaysWhyThereIsNone) {
  Shelves shelves;
  const RobotInWorld robot = shelves.in_world();
  const Positions start = Positions::Zero(7);
  Positions inside = start;
  inside[1] = 1.2;  // into the shelves
  EXPECT_THAT(plan_path(robot, start, {}).reason, HasSubstr("no goals"));
  EXPECT_THAT(plan_path(robot, inside, {start}).reason,
              AllOf(HasSubstr("at the start"), HasSubstr("'shelf'")));
  EXPECT_THAT(plan_path(robot, start, {inside}).reason,
              AllOf(HasSubstr("at the goal"), HasSubstr("'shelf'")));
  Positions beyond = start;
  beyond[3] = 3;
  EXPECT_THAT(plan_path(robot, start, {inside, beyond}).reason, HasSubstr("at every goal"));
  EXPECT_THROW(plan_path(robot, Positions::Zero(6), {start}), std::invalid_argument);
  RrtOptions bad;
  bad.step = 0;
  EXPECT_THROW(plan_path(robot, start, {start}, bad), std::invalid_argument);
  // Walled in: the search ends, and says how much it tried.
  const auto left = shelves.reach(robot, {0.65, 0.22, 0.5});
  ASSERT_FALSE(left.empty());
  RrtOptions few;
  few.iterations = 3;
  const JointPath none = plan_path(robot, left.front(), {start}, few);
  EXPECT_TRUE(none.found() || none.reason.find("3 samples") != std::string::npos) << none.reason;
}

TEST(PlanPathByOmpl, AnswersTheSameQuestions) {
  const Shelves shelves;
  const RobotInWorld robot = shelves.in_world();
  const auto left = shelves.reach(robot, {0.65, 0.22, 0.5});
  const auto right = shelves.reach(robot, {0.65, -0.22, 0.5});
  for (const OmplAlgorithm algorithm : {OmplAlgorithm::kRrtConnect, OmplAlgorithm::kBiTrrt}) {
    const JointPath path =
        plan_path_by_ompl(robot, left.front(), right, {.algorithm = algorithm, .budget = 20});
    ASSERT_TRUE(path.found()) << path.reason;
    EXPECT_FALSE(collides(shelves, path));
    EXPECT_GE(path.goal, 0);
  }
  Positions inside = Positions::Zero(7);
  inside[1] = 1.2;
  EXPECT_THAT(plan_path_by_ompl(robot, inside, right).reason, HasSubstr("at the start"));
  EXPECT_THROW(plan_path_by_ompl(robot, left.front(), right, {.budget = 0}), std::invalid_argument);
}

TEST(StraightPath, MovesTheTipAlongALine) {
  const Shelves shelves;
  const RobotInWorld robot = shelves.in_world();
  const auto inside = shelves.reach(robot, {0.65, 0.22, 0.5});
  ASSERT_FALSE(inside.empty());
  bool followed = false;
  for (const Positions& q : inside) {
    const RigidTransform X = shelves.chain.forward(q);
    const RigidTransform out = at(-0.1, 0, 0) * X;
    const JointPath path = straight_path(robot, q, out);
    if (!path.found()) {
      EXPECT_NE(path.reason, "");
      continue;
    }
    followed = true;
    EXPECT_GE(path.waypoints.size(), 11u);
    for (const Positions& way : path.waypoints) {
      const RigidTransform X_way = shelves.chain.forward(way);
      EXPECT_LT((X_way.translation() - X.translation()).tail<2>().norm(), 1e-6);
      EXPECT_TRUE(X_way.linear().isApprox(X.linear(), 1e-6));
      EXPECT_TRUE(robot.is_free(way));
    }
    EXPECT_LT(robot::difference(shelves.chain.forward(path.waypoints.back()), out), 1e-6);
  }
  EXPECT_TRUE(followed);
  const JointPath blocked =
      straight_path(robot, inside.front(), at(0, 0.3, 0) * shelves.chain.forward(inside.front()));
  EXPECT_FALSE(blocked.found());
  EXPECT_THAT(blocked.reason, HasSubstr("of 300 mm"));
  const JointPath far =
      straight_path(robot, inside.front(), at(-5, 0, 0) * shelves.chain.forward(inside.front()));
  EXPECT_FALSE(far.found());
}

}  // namespace
}  // namespace prehend::motion
