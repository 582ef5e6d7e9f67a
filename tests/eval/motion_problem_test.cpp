// Problems of motion in MotionBenchMaker's form, and the oracle that sweeps their paths.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "eval/motion/motion_trial.h"
#include "prehend/geometry/errors.h"
#include "prehend/motion/rrt_connect.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kArm = R"(<robot name="arm">
  <link name="base"/>
  <link name="upper"><collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.04 0.04"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.04 0.04"/></geometry></collision></link>
  <link name="finger"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="b" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2.9" upper="2.9" velocity="1" effort="1"/></joint>
  <joint name="grip" type="prismatic"><parent link="lower"/><child link="finger"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.05" velocity="1" effort="1"/></joint>
</robot>)";
constexpr const char* kSemantics = R"(<robot name="arm">
  <group name="arm"><chain base_link="base" tip_link="lower"/></group>
  <disable_collisions link1="upper" link2="lower" reason="Adjacent"/></robot>)";
/// A post between where the arm points and where it is to point.
constexpr const char* kScene = R"(world:
  collision_objects:
    - id: post
      primitives: [{type: cylinder, dimensions: [0.4, 0.03]}]
      primitive_poses: [{position: [0.5, 0.5, 0], orientation: [0, 0, 0, 1]}]
    - id: far
      primitives: [{type: box, dimensions: [0.1, 0.1, 0.1]}, {type: sphere, dimensions: [0.1]}]
      primitive_poses:
        - {position: [2, 0, 0], orientation: [0, 0, 0, 1]}
        - {position: [3, 0, 0], orientation: [0, 0, 0.6, 0.8]}
)";
constexpr const char* kRequest = R"(group_name: arm
start_state: {joint_state: {name: [a, b, grip], position: [0, 0, 0.05]}}
goal_constraints: [{joint_constraints: [{joint_name: a, position: 1.6}, {joint_name: b, position: 0}]}]
)";

class Problems : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_.path / name).parent_path());
    std::ofstream(folder_.path / name) << text;
  }
  std::vector<MotionProblem> read(const std::string& scene = kScene,
                                  const std::string& request = kRequest) const {
    write("set/scene0001.yaml", scene);
    write("set/request0001.yaml", request);
    return read_motion_problems(folder_.path);
  }
  std::string error_of(const std::string& scene, const std::string& request = kRequest) const {
    try {
      read(scene, request);
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "taken";
  }
  static std::string changed(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  }
  PlanningRobot robot() const {
    write("arm.urdf", kArm);
    write("arm.srdf", kSemantics);
    return read_planning_robot(folder_.path / "arm.urdf", folder_.path / "arm.srdf", "arm");
  }

  testing::TemporaryFolder folder_;
};

TEST_F(Problems, AreReadWithAllTheirShapes) {
  const auto problems = read();
  ASSERT_EQ(problems.size(), 1U);
  const MotionProblem& problem = problems[0];
  EXPECT_EQ(problem.set + "/" + problem.name, "set/0001");
  ASSERT_EQ(problem.obstacles.size(), 3U);
  EXPECT_EQ(problem.obstacles[0].radius, 0.03);
  EXPECT_EQ(problem.obstacles[0].length, 0.4);
  EXPECT_EQ(problem.obstacles[2].kind, MotionObstacle::Kind::kSphere);
  EXPECT_NEAR(problem.obstacles[2].X_BO.linear()(1, 0), 0.96, 1e-12);  // x, y, z, w
  EXPECT_EQ(problem.start.at("grip"), 0.05);
  EXPECT_EQ(problem.goal.at("a"), 1.6);
}

TEST_F(Problems, ThatAreNoneAreRefusedWithTheirPlace) {
  EXPECT_THAT(error_of("world: ["), HasSubstr("scene0001.yaml:"));
  EXPECT_THAT(error_of("a: 1"), HasSubstr("scene0001.yaml:1: has no 'world'"));
  EXPECT_THAT(error_of(changed(kScene, "cylinder", "cone")),
              HasSubstr("scene0001.yaml:4: has the shape 'cone'"));
  EXPECT_THAT(error_of(changed(kScene, "[0.4, 0.03]", "[0.4]")), HasSubstr("must be 2 numbers"));
  EXPECT_THAT(error_of(changed(kScene, "[0.4, 0.03]", "[0.4, -1]")), HasSubstr("above 0"));
  EXPECT_THAT(error_of(changed(kScene, "[0, 0, 0, 1]", "[0, 0, 0, 0]")), HasSubstr("quaternion"));
  EXPECT_THAT(error_of(changed(kScene, "0.5, 0.5", ".nan, 0.5")), HasSubstr("is no number"));
  EXPECT_THAT(error_of(kScene, "group_name: arm"), HasSubstr("request0001.yaml:1: has no 'start"));
  EXPECT_THAT(error_of(kScene, changed(kRequest, "[0, 0, 0.05]", "[0, 0]")),
              HasSubstr("a position for each joint"));
  fs::remove(folder_.path / "set/request0001.yaml");
  EXPECT_THROW(read_motion_problems(folder_.path), geometry::InputError);
  EXPECT_THROW(read_motion_problems(folder_.path / "nowhere"), geometry::InputError);
  MotionTrials trials(robot(), {});
  MotionProblem problem = read()[0];
  problem.goal.erase("b");
  EXPECT_THROW(trials.invalid_problem(problem), geometry::InputError);
  EXPECT_THROW(read_planning_robot(folder_.path / "arm.urdf", folder_.path / "arm.srdf", "leg"),
               geometry::InputError);
}

TEST_F(Problems, AreSolvedRoundThePostAndSweptFreeOfIt) {
  const MotionProblem problem = read()[0];
  MotionTrialOptions options;
  options.ball_resolutions = {0.05, 0.02};
  MotionTrials trials(with_fixed(robot(), problem.start), options);
  EXPECT_EQ(trials.invalid_problem(problem), "");
  const MotionResult result = trials.run(problem, motion::RrtConnect());
  EXPECT_TRUE(result.solved) << result.reason;
  EXPECT_EQ(result.invalid, "");
  EXPECT_GT(result.length, 1.6);  // the straight way is not free
  // One whose goal is in the post is none.
  MotionProblem bad = problem;
  bad.goal["a"] = 0.78;
  EXPECT_THAT(trials.invalid_problem(bad), HasSubstr("at the goal, 'lower' touches 'post'"));
  EXPECT_FALSE(trials.run(bad, motion::RrtConnect()).solved);
}

TEST_F(Problems, PathsThatTouchAreFoundBetweenTheirWaypoints) {
  const auto arm = robot();
  PathOracle oracle(arm.model, arm.base, arm.tip, arm.may_touch);
  const MotionProblem problem = read()[0];
  oracle.set_obstacles(problem.obstacles);
  const Eigen::Vector2d start(0, 0), goal(1.6, 0), folded(0, -2.6), turned(1.6, -2.6);
  EXPECT_THAT(oracle.problem_along({start, goal}, 1.0 / 512), HasSubstr("'lower' touches 'post'"));
  EXPECT_EQ(oracle.problem_along({start, folded, turned}, 1.0 / 512), "");
  EXPECT_THAT(oracle.problem(Eigen::Vector2d(0, 3)), HasSubstr("beyond"));  // its limit
  // Neighbours may touch by the SRDF; where it does not say so they do.
  PathOracle strict(arm.model, arm.base, arm.tip, {});
  EXPECT_THAT(strict.problem(start), HasSubstr("'upper' touches 'lower'"));
}

}  // namespace
}  // namespace prehend::eval
