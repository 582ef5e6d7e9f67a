// prehend home and prehend hand at simulated robots, and which robot a graph has.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "msgs/actions.pb.h"
#include "tests/tools/jogged_robot.h"

namespace prehend::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;

struct Ended {
  int exit_code;
  std::string output;
};

Ended run(const std::vector<std::string>& words, const std::string& registry) {
  ScratchDirectory folder;
  ChildProgram program("prehend", words, folder.path("out"), registry);
  const int exit_code = program.wait(60s).value_or(-1);
  return {exit_code, program.output()};
}

msgs::FollowTrajectoryResult follow(JoggedRobot& robot, const std::string& joint, double way) {
  const auto client = robot.node()
                          .action_client<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                                         msgs::FollowTrajectoryResult>("/arm/follow");
  const msgs::JointState now = robot.state();
  msgs::FollowTrajectoryGoal goal;
  for (const double share : {0.0, 1.0}) {
    auto& point = *goal.mutable_trajectory()->add_points();
    point.set_time(share * 2);
    for (int i = 0; i < now.name_size(); ++i) {
      if (now.name(i).rfind("arm_", 0) != 0) continue;
      if (share == 0) goal.mutable_trajectory()->add_joint_name(now.name(i));
      point.add_position(now.position(i) + (now.name(i) == joint ? share * way : 0.0));
      point.add_velocity(0);
    }
  }
  const auto outcome = client.send(goal).wait(30s);
  EXPECT_TRUE(outcome.ok()) << outcome.error();
  return outcome.ok() ? *outcome : msgs::FollowTrajectoryResult();
}

TEST(HomeAndHand, OfAnArmWithAHand) {
  JoggedRobot robot("kr5_sdh");
  // The hand: preshapes by name, closing, what it says.
  const Ended listed = run({"hand", "list"}, robot.registry());
  EXPECT_EQ(listed.exit_code, 0);
  EXPECT_THAT(listed.output, AllOf(HasSubstr("hand sdh2 of kr5_sdh (node simulation)"),
                                   HasSubstr("spherical"), HasSubstr("pivot 60.0 deg")));
  const Ended shaped = run({"hand", "tripod", "--speed", "1"}, robot.registry());
  EXPECT_EQ(shaped.exit_code, 0) << shaped.output;
  EXPECT_THAT(shaped.output, AllOf(HasSubstr("done"), HasSubstr("pivot 60.0 deg")));
  EXPECT_NEAR(robot.position("hand_pivot"), 1.0472, 0.01);
  const Ended closed = run({"hand", "close", "--force", "3", "--speed", "1"}, robot.registry());
  EXPECT_EQ(closed.exit_code, 0) << closed.output;
  EXPECT_THAT(closed.output, HasSubstr("closed"));
  EXPECT_GT(robot.position("hand_thumb_proximal"), 0) << "by the preshape that it stood in";
  EXPECT_NEAR(robot.position("hand_pivot"), 1.0472, 0.02);
  const Ended opened = run({"hand", "open", "--speed", "1"}, robot.registry());
  EXPECT_EQ(opened.exit_code, 0) << opened.output;
  EXPECT_NEAR(robot.position("hand_thumb_proximal"), -0.45, 0.02) << "and as that";
  const auto refused = [&](const std::vector<std::string>& words, const std::string& why) {
    const Ended ended = run(words, robot.registry());
    EXPECT_EQ(ended.exit_code, 1) << ended.output;
    EXPECT_THAT(ended.output, HasSubstr(why));
  };
  refused({"hand", "tripd"}, "hand sdh2 has no 'tripd'; did you mean \"tripod\"?");
  refused({"hand", "close", "--force", "500"}, "a force of 500.0 N is more than joint");
  refused({"hand", "open", "--force", "5"}, "--force is of close");
  refused({"hand", "close", "--preshape", "pinsh"}, "pinch");
  refused({"home", "--to", "hom"}, "home");
  refused({"home", "--platform", "kr5_shd"}, "kr5_sdh");
  refused({"home", "--platform", "stage_pg70", "--patience", "1"},
          "/joint_states with the joints of stage_pg70's arm did not come within 1 s; "
          "/joint_states has no 'arm_x'");

  // Home: from elsewhere, with the hand open.
  EXPECT_TRUE(follow(robot, "arm_axis_1", 0.6).reached());
  EXPECT_TRUE(follow(robot, "arm_axis_2", 0.4).reached());
  EXPECT_EQ(run({"hand", "close", "--speed", "1"}, robot.registry()).exit_code, 0);
  refused({"home", "--table", "1.5", "--keep-hand"}, "where it stands, the link of joint");
  const Ended home = run({"home", "--speed", "0.5"}, robot.registry());
  EXPECT_EQ(home.exit_code, 0) << home.output;
  EXPECT_THAT(home.output, HasSubstr("the arm is at 'home'"));
  EXPECT_NEAR(robot.position("arm_axis_1"), 0, 1e-2);
  EXPECT_NEAR(robot.position("arm_axis_2"), -1.5707963, 1e-2);
  EXPECT_THAT(run({"home"}, robot.registry()).output, HasSubstr("the arm is at 'home'"));
  // Ctrl-C on the way.
  ScratchDirectory folder;
  ChildProgram side("prehend", {"home", "--to", "side", "--speed", "0.05", "--keep-hand"},
                    folder.path("out"), robot.registry());
  ASSERT_TRUE(eventually([&] { return robot.velocity("arm_axis_1") > 0.02; }, 30s))
      << side.output();
  kill(side.pid(), SIGINT);
  EXPECT_EQ(side.wait(20s), 1);
  EXPECT_THAT(side.output(), HasSubstr("prehend home: interrupted: the arm was stopped"));
  EXPECT_TRUE(robot.stands());
  EXPECT_LT(robot.position("arm_axis_1"), 1.1);

  // Another node means another robot.
  graph::NodeOptions options;
  options.name = "planner";
  options.registry = robot.registry();
  graph::Node other(options);
  other.declare_parameter<std::string>({.name = "platform", .default_value = "stage_pg70"});
  other.spin_in_background();
  refused({"hand", "list"}, "name yours by --platform");
  EXPECT_EQ(run({"hand", "list", "--platform", "kr5_sdh"}, robot.registry()).exit_code, 0);
}

TEST(HomeAndHand, OfAStageWithAGripper) {
  JoggedRobot robot("stage_pg70");
  const Ended closed = run({"hand", "close", "--speed", "1"}, robot.registry());
  EXPECT_EQ(closed.exit_code, 0) << closed.output;
  EXPECT_THAT(closed.output, AllOf(HasSubstr("hand pg70 of stage_pg70"), HasSubstr("opening ")));
  EXPECT_LT(robot.opening(), 0.01);
  const Ended opened = run({"hand", "open", "--speed", "1"}, robot.registry());
  EXPECT_EQ(opened.exit_code, 0) << opened.output;
  EXPECT_NEAR(robot.opening(), 0.069, 1e-3);
  EXPECT_TRUE(follow(robot, "arm_x", 0.2).reached());
  const Ended home = run({"home", "--speed", "1"}, robot.registry());
  EXPECT_EQ(home.exit_code, 0) << home.output;
  EXPECT_NEAR(robot.position("arm_x"), -0.35, 1e-3);
}

TEST(HomeAndHand, WithoutARobotTheyEndAndSayWhatIsMissing) {
  graph::Registry registry({.endpoint = "tcp://127.0.0.1:*"});
  for (const char* command : {"home", "hand"}) {
    std::vector<std::string> words{command, "--patience", "0.3"};
    if (words.front() == "hand") words.push_back("open");
    const Ended ended = run(words, registry.endpoint());
    EXPECT_EQ(ended.exit_code, 1);
    EXPECT_THAT(ended.output, HasSubstr("did not come within"));
  }
  EXPECT_EQ(run({"home"}, "tcp://127.0.0.1:1").exit_code, 1);
}

}  // namespace
}  // namespace prehend::testing
