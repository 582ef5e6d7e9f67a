// What touches, by the robot's balls, and by its shapes with other checkers.

#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/motion/checker_registry.h"
#include "prehend/motion/pick_motion.h"
#include "prehend/motion/planner_registry.h"
#include "prehend/motion/robot_in_world.h"
#include "prehend/robot/platform.h"
#include "tests/motion/pick_scene.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using robot::Positions;
using ::testing::HasSubstr;

RigidTransform any_pose(std::mt19937_64& random, double reach) {
  const auto uniform = [&random] { return 2 * robot::uniform(random) - 1; };
  const Eigen::Vector4d q(uniform(), uniform(), uniform(), uniform());
  RigidTransform X = RigidTransform::Identity();
  X.linear() = Eigen::Quaterniond(q).normalized().toRotationMatrix();
  X.translation() = reach * Vector3d(uniform(), uniform(), uniform());
  return X;
}

std::vector<Positions> positions(const robot::KinematicChain& chain, int count) {
  std::mt19937_64 random(9);
  std::vector<Positions> result;
  for (int i = 0; i < count; ++i) result.push_back(robot::random_positions(chain, random));
  return result;
}

ConvexBody ball(double radius) {
  ConvexBody body;
  body.kind = ConvexBody::Kind::kSphere;
  body.radius = radius;
  return body;
}

ConvexBody box(const Vector3d& size) {
  ConvexBody body;
  body.size = size;
  return body;
}

ConvexBody cylinder(double radius, double length) {
  ConvexBody body;
  body.kind = ConvexBody::Kind::kCylinder;
  body.radius = radius;
  body.length = length;
  return body;
}

/// The corners of a box.
ConvexBody hull(const Vector3d& size) {
  ConvexBody body;
  body.kind = ConvexBody::Kind::kPoints;
  body.points = std::make_shared<const std::vector<Vector3d>>(geometry::make_box(size).vertices);
  return body;
}

class CheckerNamed : public ::testing::TestWithParam<std::string> {
 protected:
  std::shared_ptr<const CollisionChecker> checker = CheckerRegistry().create(GetParam());

  /// Whether the checker's distance of two bodies is `distance` [m], seen from anywhere.
  void expect_distance(const ConvexBody& a, const ConvexBody& b, const RigidTransform& X_AB,
                       double distance) const {
    constexpr double kTolerance = 2e-4;  // m, of Bullet's
    const auto of_a = checker->body(a), of_b = checker->body(b);
    std::mt19937_64 random(1);
    for (int i = 0; i < 20; ++i) {
      const RigidTransform X_BA = any_pose(random, 1);
      const auto nearer = [&](double gap) {
        return checker->are_nearer(*of_a, X_BA, *of_b, X_BA * X_AB, gap) &&
               checker->are_nearer(*of_b, X_BA * X_AB, *of_a, X_BA, gap);
      };
      EXPECT_TRUE(nearer(std::max(0.0, distance) + kTolerance)) << distance;
      EXPECT_EQ(nearer(0), distance < 0) << distance;
      if (distance > 0) {
        EXPECT_FALSE(nearer(distance - kTolerance)) << distance;
      }
    }
  }
};

TEST_P(CheckerNamed, KnowsDistancesInClosedForm) {
  EXPECT_EQ(checker->name(), GetParam());
  EXPECT_NE(checker->about(), "");
  for (const double gap : {-0.01, 0.001, 0.05, 0.4}) {
    expect_distance(ball(0.1), ball(0.2), at(0, 0, 0.3 + gap), gap);
    expect_distance(box({0.2, 0.3, 0.4}), ball(0.05), at(0.15 + gap, 0.1, 0.1), gap);
    expect_distance(cylinder(0.1, 0.6), ball(0.05), at(0.15 + gap, 0, 0.2), gap);
    expect_distance(cylinder(0.1, 0.6), ball(0.05), at(0, 0.03, 0.35 + gap), gap);
    expect_distance(cylinder(0.1, 0.6), box({0.2, 0.2, 0.2}), at(0, 0.2 + gap, 0.2), gap);
    expect_distance(box({0.2, 0.3, 0.4}), box({0.1, 0.1, 0.1}), at(0.1, 0.1, 0.25 + gap), gap);
    expect_distance(hull({0.2, 0.3, 0.4}), ball(0.05), at(0, 0.2 + gap, 0.15), gap);
    expect_distance(hull({0.2, 0.3, 0.4}), hull({0.2, 0.2, 0.2}), at(0.2 + gap, 0.1, 0.15), gap);
    // Edge to edge: 45 degrees about z, corners of squares towards each other.
    RigidTransform turned = at(0.1 + 0.1 * std::sqrt(2.0) + gap, 0, 0);
    turned.linear() = Eigen::AngleAxisd(std::numbers::pi / 4, Vector3d::UnitZ()).toRotationMatrix();
    expect_distance(box({0.2, 0.2, 0.3}), hull({0.2, 0.2, 0.1}), turned, gap);
  }
  // A ball's middle deep inside.
  expect_distance(box({0.2, 0.3, 0.4}), ball(0.01), at(0.01, 0.02, 0.03), -0.08);
}

// Whatever form a robot's file has for a convex shape.
TEST_P(CheckerNamed, TakesMeshesAsTheirHulls) {
  PickScene scene("kr5", {0.5, 0.2, 0});
  robot::RobotModel meshes = scene.model;
  int changed = 0;
  for (robot::Link& link : meshes.links) {
    for (robot::CollisionShape& shape : link.shapes) {
      if (shape.kind != robot::CollisionShape::Kind::kBox) continue;
      shape.kind = robot::CollisionShape::Kind::kMesh;
      shape.solid = std::make_shared<const geometry::TriangleMesh>(geometry::make_box(shape.size));
      ++changed;
    }
  }
  ASSERT_GT(changed, 0);
  RobotInWorld of_boxes = scene.in_world(), of_meshes = scene.in_world();
  of_boxes.use_checker(checker, make_robot_shapes(scene.model, "base_link", "grip"));
  of_meshes.use_checker(checker, make_robot_shapes(meshes, "base_link", "grip"));
  int free = 0;
  for (const Positions& q : positions(scene.chain, 300)) {
    free += of_boxes.is_free(q);
    EXPECT_EQ(of_meshes.is_free(q), of_boxes.is_free(q)) << of_boxes.problem(q);
  }
  EXPECT_GT(free, 20);
}

TEST_P(CheckerNamed, SaysWhatTouchesWhat) {
  PickScene scene("kr5", {0.5, 0.2, 0});
  RobotInWorld robot = scene.in_world();
  robot.use_checker(checker, make_robot_shapes(scene.model, "base_link", "grip"));
  const auto poses = positions(scene.chain, 400);
  int free = 0, table = 0, itself = 0;
  for (const Positions& q : poses) {
    const std::string problem = robot.problem(q);
    EXPECT_EQ(problem.empty(), robot.is_free(q)) << problem;
    EXPECT_EQ(robot.not_free(&q, 1), problem.empty() ? 0u : 1u);
    free += problem.empty();
    table += problem.find("touches 'table'") != std::string::npos;
    itself += problem.find("touches the link") != std::string::npos;
  }
  EXPECT_GT(free, 20);
  EXPECT_GT(table, 20);
  EXPECT_GT(itself, 5);
  // What may be touched: the hand the table, not the arm.
  robot.change_world([](CollisionWorld& world) {
    world.set_margin("table", Part::kHand, -CollisionWorld::kInfinity);
  });
  int allowed = 0;
  for (const Positions& q : poses) {
    const std::string problem = robot.problem(q);
    EXPECT_THAT(problem,
                ::testing::Not(HasSubstr(scene.chain.joints().back().name + "' touches 'table'")));
    allowed += problem.empty();
  }
  EXPECT_GT(allowed, free);
  // A plane in the table's place is the same, where it is as large.
  RobotInWorld on_plane = scene.in_world();
  on_plane.use_checker(checker, make_robot_shapes(scene.model, "base_link", "grip"));
  on_plane.change_world([](CollisionWorld& world) {
    world.remove("table");
    world.add_plane("plane", {Vector3d::UnitZ(), 0});
  });
  RobotInWorld on_table = scene.in_world();
  on_table.use_checker(checker, make_robot_shapes(scene.model, "base_link", "grip"));
  int differ = 0;
  for (const Positions& q : poses) differ += on_plane.is_free(q) != on_table.is_free(q);
  EXPECT_LE(differ, 2);
  // Back to the balls.
  const RobotInWorld balls = scene.in_world();
  robot = scene.in_world();
  robot.use_checker(checker, make_robot_shapes(scene.model, "base_link", "grip"));
  robot.use_checker(nullptr, {});
  for (const Positions& q : poses) EXPECT_EQ(robot.problem(q), balls.problem(q));
}

TEST_P(CheckerNamed, CountsWhatIsHeld) {
  PickScene scene("kr5", {0.5, 0.2, 0});
  RobotInWorld robot = scene.in_world();
  robot.use_checker(checker, make_robot_shapes(scene.model, "base_link", "grip"));
  // A rod of half a metre, ahead of the hand.
  std::vector<RobotSphere> rod;
  for (int i = 1; i <= 10; ++i) rod.push_back({-1, Vector3d(0, 0, 0.05 * i), 0.03});
  RobotInWorld with_rod = robot;
  with_rod.attach(rod);
  RobotInWorld by_balls = scene.in_world();
  by_balls.attach(rod);
  int only_rod = 0;
  for (const Positions& q : positions(scene.chain, 400)) {
    const std::string problem = with_rod.problem(q);
    if (robot.is_free(q) && !problem.empty()) {
      ++only_rod;
      EXPECT_THAT(problem, HasSubstr("what is held"));
    }
    EXPECT_LE(with_rod.is_free(q), robot.is_free(q));
    EXPECT_LE(by_balls.is_free(q), with_rod.is_free(q)) << problem;
  }
  EXPECT_GT(only_rod, 20);
  with_rod.detach();
  for (const Positions& q : positions(scene.chain, 50)) {
    EXPECT_EQ(with_rod.problem(q), robot.problem(q));
  }
}

TEST_P(CheckerNamed, SweepsWhatIsBetween) {
  PickScene scene("kr5", {0.5, 0.2, 0});
  // Thin things that steps of 0.05 can jump over.
  for (int i = 0; i < 24; ++i) {
    scene.add("rod", at(0.6 * std::cos(i), 0.6 * std::sin(i), 0.5), {0.004, 0.004, 1});
  }
  RobotInWorld robot = scene.in_world();
  robot.use_checker(checker, make_robot_shapes(scene.model, "base_link", "grip"));
  std::vector<RobotSphere> rod;
  for (int i = 1; i <= 4; ++i) rod.push_back({-1, Vector3d(0, 0, 0.02 * i), 0.01});
  robot.attach(rod);
  std::mt19937_64 random(5);
  int swept = 0, refused = 0, jumped = 0;
  for (int k = 0; k < 400; ++k) {
    const Positions from = robot::random_positions(scene.chain, random);
    Positions to = from;
    for (int j = 0; j < to.size(); ++j) to[j] += 0.6 * (robot::uniform(random) - 0.5);
    if (!robot.is_free(from) || !robot.is_free(to)) continue;
    bool touches = false;
    for (int i = 0; i <= 300 && !touches; ++i) {
      const Positions q = from + i / 300.0 * (to - from);
      // Touches in earnest: without the margin.
      touches = scene.oracle.collides(scene.chain, q);
    }
    const bool is_swept = robot.is_swept_free(from, to);
    EXPECT_FALSE(is_swept && touches);
    EXPECT_TRUE(!is_swept || robot.is_free_between(from, to, 0.5));
    jumped += touches && robot.is_free_between(from, to, 0.2);
    (is_swept ? swept : refused) += 1;
  }
  EXPECT_GT(swept, 30);
  EXPECT_GT(refused, 4);
  EXPECT_GT(jumped, 0);  // else the test shows nothing
}

INSTANTIATE_TEST_SUITE_P(Checkers, CheckerNamed, ::testing::Values("fcl", "bullet"),
                         [](const auto& checker) { return checker.param; });

/// A platform among a table, boxes and convex pieces, with the hand open.
struct Crowd {
  robot::Platform platform;
  robot::RobotModel model;
  robot::KinematicChain chain;
  CollisionWorld world;

  explicit Crowd(const std::string& name)
      : platform(robot::read_platform("config/robots/" + name + ".yaml")),
        model(platform.with_hand_at(
            platform.hand.all_positions(platform.hand.preshapes.front().open))),
        chain(platform.arm_chain()) {
    // Round the base of an arm; a stage hangs over them.
    const double low = chain.joints().front().is_revolute ? 0 : -1.4;  // m
    world.add_box("table", at(0.5, 0, low - 0.1), {1.2, 1.2, 0.2});
    std::mt19937_64 random(3);
    for (int i = 0; i < 6; ++i) {
      const double angle = i;
      RigidTransform X = any_pose(random, 0.1);
      X.translation() +=
          Vector3d(0.6 * std::cos(angle), 0.6 * std::sin(angle), low + 0.4 + 0.1 * i);
      world.add_box("box", X, {0.1, 0.2, 0.3});
    }
    for (int i = 0; i < 6; ++i) {
      const RigidTransform X = any_pose(random, 0.7);
      geometry::TriangleMesh piece;
      for (int k = 0; k < 40; ++k) {
        const Vector3d at_piece = any_pose(random, 1).translation().normalized();
        piece.vertices.push_back(X * Vector3d(at_piece.cwiseProduct(Vector3d(0.05, 0.1, 0.15))) +
                                 Vector3d(0, 0, low + 0.8));
      }
      world.add_convex("piece", piece);
    }
  }
  /// Without margins; the links' shapes `larger` on all sides [m].
  RobotInWorld by(const std::string& checker, double larger = 0) const {
    RobotInWorld robot(chain, make_robot_spheres(model, platform.base, platform.flange, 0.04),
                       world, 0);
    std::vector<RobotShape> shapes = make_robot_shapes(model, platform.base, platform.flange);
    for (RobotShape& shape : shapes) {
      shape.body.size.array() += 2 * larger;
      shape.body.radius += larger;
      shape.body.length += 2 * larger;
    }
    robot.use_checker(CheckerRegistry().create(checker), shapes);
    return robot;
  }
};

class CheckersOn : public ::testing::TestWithParam<std::string> {};

TEST_P(CheckersOn, AgreeOnTenThousandPoses) {
  // m: FCL and Bullet differ on 11, 9 and 1 of 10,000 poses, in which links of the one that says
  // free need to be larger by 0.045 mm at most to touch for it too (measured by bisection).
  constexpr double kBand = 1e-4;
  const Crowd crowd(GetParam());
  const RobotInWorld balls = crowd.by("balls"), fcl = crowd.by("fcl"), bullet = crowd.by("bullet"),
                     larger_fcl = crowd.by("fcl", kBand), larger_bullet = crowd.by("bullet", kBand);
  std::mt19937_64 random(11);
  int free = 0, free_by_balls = 0;
  for (int i = 0; i < 10000; ++i) {
    const Positions q = robot::random_positions(crowd.chain, random);
    const bool free_by_fcl = fcl.is_free(q), free_by_bullet = bullet.is_free(q);
    free += free_by_fcl;
    if (balls.is_free(q)) {
      ++free_by_balls;
      EXPECT_TRUE(free_by_fcl) << fcl.problem(q);
      EXPECT_TRUE(free_by_bullet) << bullet.problem(q);
    }
    if (free_by_fcl == free_by_bullet) continue;
    EXPECT_FALSE((free_by_fcl ? larger_fcl : larger_bullet).is_free(q))
        << fcl.problem(q) << bullet.problem(q);
  }
  EXPECT_GT(free, 3000);
  EXPECT_GT(free_by_balls, 2000);
  EXPECT_GT(free, free_by_balls);  // what balls are larger costs free positions
}

INSTANTIATE_TEST_SUITE_P(Platforms, CheckersOn,
                         ::testing::Values("kr5_pg70", "kr5_sdh", "pa10_barrett", "stage_pg70"),
                         [](const auto& platform) { return platform.param; });

TEST(PickMotion, EveryPlannerAndCheckerPicks) {
  PickScene scene("kr5", {0.5, 0.2, 0});
  scene.add("left", at(0.5, 0.4, 0.1), {0.1, 0.1, 0.2});
  scene.add("right", at(0.5, -0.02, 0.15), {0.2, 0.05, 0.3});
  scene.task.X_BO_places = {at(0.45, -0.25, 0.081)};
  scene.grasps_from_above();
  scene.task.start[0] = -1;
  const robot::InverseKinematics inverse = scene.inverse();
  const std::vector<RobotShape> shapes = make_robot_shapes(scene.model, "base_link", "grip");
  for (const std::string& checker : CheckerRegistry().names()) {
    RobotInWorld robot = scene.in_world();
    robot.use_checker(CheckerRegistry().create(checker), shapes);
    for (const std::string& planner : PlannerRegistry().names()) {
      PickOptions options;
      options.planner = planner;
      options.acceleration = Eigen::VectorXd::Constant(scene.chain.size(), 5.0);
      const PickMotion motion = plan_pick(robot, inverse, scene.task, options);
      ASSERT_TRUE(motion.found()) << planner << " " << checker << ": " << motion.problem;
      EXPECT_EQ(scene.problem(motion), "") << planner << " " << checker;
      EXPECT_EQ(motion.place, 0);
    }
  }
  PickOptions misspelt;
  misspelt.planner = "rrt_conect";
  try {
    plan_pick(scene.in_world(), inverse, scene.task, misspelt);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("nearest is 'rrt_connect'"), HasSubstr("ompl_bitrrt")));
  }
}

TEST(UseChecker, RefusesShapesOfAnotherRobot) {
  PickScene scene("kr5", {0.5, 0.2, 0});
  std::vector<RobotShape> shapes = make_robot_shapes(scene.model, "base_link", "grip");
  shapes.back().joint = scene.chain.size();
  RobotInWorld robot = scene.in_world();
  EXPECT_THROW(robot.use_checker(CheckerRegistry().create("fcl"), shapes), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::motion
