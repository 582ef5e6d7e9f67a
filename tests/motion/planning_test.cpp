// Paths in joint space.

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/motion/plan_path.h"
#include "prehend/motion/planner_registry.h"
#include "prehend/motion/rrt_connect.h"
#include "tests/motion/shelves.h"
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
  PathOptions plain;
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
  PathOptions bad;
  bad.step = 0;
  EXPECT_THROW(plan_path(robot, start, {start}, bad), std::invalid_argument);
  // Walled in: the search ends, and says how much it tried.
  const auto left = shelves.reach(robot, {0.65, 0.22, 0.5});
  ASSERT_FALSE(left.empty());
  PathOptions few;
  few.iterations = 3;
  const JointPath none = plan_path(robot, left.front(), {start}, few);
  EXPECT_TRUE(none.found() || none.reason.find("3 samples") != std::string::npos) << none.reason;
}

/// A cube of three joints, 0 to 1, with a wall between 0.4 and 0.6 of the first, which is open
/// where the others are above 1 - `bridge`.
class Islands final : public FreeSpace {
 public:
  double bridge = 0;

  int size() const override { return 3; }
  double lower(int) const override { return 0; }
  double upper(int) const override { return 1; }
  bool is_free(const Eigen::Ref<const Eigen::VectorXd>& q) const override {
    if (q.minCoeff() < 0 || q.maxCoeff() > 1) return false;
    return std::abs(q[0] - 0.5) > 0.1 || q.tail<2>().minCoeff() > 1 - bridge;
  }
  std::string problem(const Eigen::Ref<const Eigen::VectorXd>& q) const override {
    return is_free(q) ? "" : "in the wall";
  }
  std::uint32_t not_free(const Positions* q, int count) const override {
    std::uint32_t mask = 0;
    for (int i = 0; i < count; ++i) mask |= is_free(q[i]) ? 0u : 1u << i;
    return mask;
  }
  bool is_free_between(const Eigen::Ref<const Eigen::VectorXd>& from,
                       const Eigen::Ref<const Eigen::VectorXd>& to, double step) const override {
    const int steps = 1 + static_cast<int>((to - from).cwiseAbs().maxCoeff() / step);
    for (int i = 0; i <= steps; ++i) {
      if (!is_free(from + (static_cast<double>(i) / steps) * (to - from))) return false;
    }
    return true;
  }
  bool is_swept_free(const Eigen::Ref<const Eigen::VectorXd>& from,
                     const Eigen::Ref<const Eigen::VectorXd>& to) const override {
    return is_free_between(from, to, 1e-3);
  }
};

/// Each planner that is built in.
class PlannerNamed : public ::testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<PathPlanner> planner = PlannerRegistry().create(GetParam());
  Shelves shelves;
  RobotInWorld robot = shelves.in_world();
  std::vector<Positions> left = shelves.reach(robot, {0.65, 0.22, 0.5});
  std::vector<Positions> right = shelves.reach(robot, {0.65, -0.22, 0.5});
};

TEST_P(PlannerNamed, FindsAPathThatIsSweptFree) {
  EXPECT_EQ(planner->name(), GetParam());
  EXPECT_NE(planner->about(), "");
  ASSERT_FALSE(left.empty());
  ASSERT_FALSE(right.empty());
  // Pieces are parts of lines that are swept free: other positions of them are tested here, which
  // keep from touching, but perhaps not the whole margin.
  const RobotInWorld touching(robot.chain(), robot.spheres(), robot.world(), 0);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    PathOptions options;
    options.seed = seed;
    const JointPath path = plan_path(*planner, robot, left.front(), right, options);
    ASSERT_TRUE(path.found()) << path.reason;
    EXPECT_EQ(path.waypoints.front(), left.front());
    ASSERT_GE(path.goal, 0);
    EXPECT_LT((path.waypoints.back() - right[static_cast<std::size_t>(path.goal)]).norm(), 1e-9);
    for (std::size_t i = 1; i < path.waypoints.size(); ++i) {
      EXPECT_TRUE(touching.is_swept_free(path.waypoints[i - 1], path.waypoints[i]));
    }
    EXPECT_FALSE(collides(shelves, path));
  }
}

class RepeatablePlanner : public PlannerNamed {};

TEST_P(PlannerNamed, SaysWhetherItIsRepeatable) {
  const bool says_not = planner->about().find("not repeatable") != std::string::npos;
  EXPECT_EQ(says_not, GetParam() == "ompl_kpiece") << "which draws by the clock";
}

TEST_P(RepeatablePlanner, GivesTheSamePathForTheSameSeed) {
  PathOptions options;
  options.seed = 7;
  const JointPath path = plan_path(*planner, robot, left.front(), right, options);
  for (int i = 0; i < 3; ++i) {
    const JointPath again = plan_path(*planner, robot, left.front(), right, options);
    ASSERT_EQ(again.waypoints.size(), path.waypoints.size());
    for (std::size_t k = 0; k < path.waypoints.size(); ++k) {
      EXPECT_EQ(again.waypoints[k], path.waypoints[k]);
    }
  }
  options.seed = 8;
  EXPECT_NE(plan_path(*planner, robot, left.front(), right, options).length(), path.length());
}

TEST_P(PlannerNamed, SaysWhyThereIsNone) {
  const Positions start = Positions::Zero(7);
  Positions inside = start;
  inside[1] = 1.2;  // into the shelves
  EXPECT_THAT(plan_path(*planner, robot, inside, right).reason,
              AllOf(HasSubstr("at the start"), HasSubstr("'shelf'")));
  EXPECT_THAT(plan_path(*planner, robot, start, {inside}).reason, HasSubstr("at the goal"));
  EXPECT_THAT(plan_path(*planner, robot, start, {}).reason, HasSubstr("no goals"));
  // Beside one that is not free, the other is named by its index among all.
  EXPECT_EQ(plan_path(*planner, robot, left.front(), {inside, left.front()}).goal, 1);
  const auto refused = [&](auto change) {
    PathOptions bad;
    change(bad);
    EXPECT_THROW(plan_path(*planner, robot, left.front(), right, bad), std::invalid_argument);
  };
  refused([](PathOptions& options) { options.step = 0; });
  refused([](PathOptions& options) { options.resolution = std::nan(""); });
  refused([](PathOptions& options) { options.iterations = 0; });
  refused([](PathOptions& options) { options.budget = -1; });
  refused([](PathOptions& options) { options.shortcuts = -1; });
  EXPECT_THROW(plan_path(*planner, robot, Positions::Zero(6), right), std::invalid_argument);
}

TEST_P(PlannerNamed, EndsWhenItMay) {
  const Islands apart;
  const Positions one = Positions::Constant(3, 0.1), other = Positions::Constant(3, 0.9);
  PathOptions few;
  few.iterations = 200;
  const JointPath none = plan_path(*planner, apart, one, {other}, few);
  EXPECT_FALSE(none.found());
  EXPECT_THAT(none.reason, HasSubstr("no path"));
  EXPECT_EQ(none.goal, -1);
  PathOptions hurried;
  hurried.budget = 0.02;
  hurried.iterations = 1000000000;
  EXPECT_FALSE(plan_path(*planner, apart, one, {other}, hurried).found());
  Islands bridged;
  bridged.bridge = 0.2;
  PathOptions fine;
  fine.resolution = fine.step = 0.05;
  fine.iterations = 2000000;  // one that draws by the clock had no luck with 20000
  const JointPath over = plan_path(*planner, bridged, one, {other}, fine);
  ASSERT_TRUE(over.found()) << over.reason;
  EXPECT_GE(over.waypoints.size(), 3u);
}

INSTANTIATE_TEST_SUITE_P(Planners, PlannerNamed,
                         ::testing::Values("rrt_connect", "ompl_rrt_connect", "ompl_bitrrt",
                                           "ompl_kpiece"),
                         [](const auto& planner) { return planner.param; });

INSTANTIATE_TEST_SUITE_P(Planners, RepeatablePlanner,
                         ::testing::Values("rrt_connect", "ompl_rrt_connect", "ompl_bitrrt"),
                         [](const auto& planner) { return planner.param; });

/// A straight line to the goal, whatever is there, or what a careless plug-in may say.
class Careless final : public PathPlanner {
 public:
  std::string name() const override { return "careless"; }
  std::string about() const override { return "for tests"; }
  JointPath plan(const FreeSpace&, const Eigen::Ref<const Eigen::VectorXd>& start,
                 const std::vector<Positions>& goals, const PathOptions&) const override {
    JointPath path;
    path.waypoints = {start, ends_elsewhere ? Positions(1.1 * goals.front()) : goals.front()};
    path.goal = goal;
    return path;
  }
  bool ends_elsewhere = false;
  int goal = 0;
};

TEST(PlanPath, DoesNotTrustPlanners) {
  const Shelves shelves;
  const RobotInWorld robot = shelves.in_world();
  const auto left = shelves.reach(robot, {0.65, 0.22, 0.5});
  const auto right = shelves.reach(robot, {0.65, -0.22, 0.5});
  Careless careless;
  EXPECT_THAT(plan_path(careless, robot, left.front(), right).reason,
              HasSubstr("touches something between"));
  careless.goal = 1000;
  EXPECT_THAT(plan_path(careless, robot, left.front(), right).reason, HasSubstr("'careless'"));
  careless.goal = 0;
  careless.ends_elsewhere = true;
  EXPECT_THAT(plan_path(careless, robot, left.front(), right).reason, HasSubstr("'careless'"));
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
