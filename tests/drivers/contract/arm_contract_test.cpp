// What every arm offers, be it simulated or behind RSI: the topic, the action, its results and
// words of refusal, stops.

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/kuka_rsi/transport/udp_socket.h"
#include "drivers/wire/stream/tcp_server.h"
#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Goal = msgs::FollowTrajectoryGoal;
using Result = msgs::FollowTrajectoryResult;

struct ArmKind {
  std::string name, launch_file;
  std::vector<std::string> arguments;  // PORT: a free one
  friend void PrintTo(const ArmKind& kind, std::ostream* out) { *out << kind.name; }
};

/// The running arm, and a node that uses it.
class ArmUnderTest {
 public:
  explicit ArmUnderTest(const ArmKind& kind)
      : registry_(TcpServer().name()),
        launched_("prehend", arguments_of(kind), scratch_.path() / "output.txt"),
        node_(options()),
        follow(node_.action_client<Goal, msgs::FollowTrajectoryFeedback, Result>("/arm/follow")),
        joints_(node_.subscribe<msgs::JointState>(
            "/joint_states", graph::QoS::queue(200),
            [this](const graph::Received<msgs::JointState>& message) {
              const std::lock_guard lock(mutex_);
              states_.push_back(*message);
            })) {
    node_.spin_in_background();
  }
  ~ArmUnderTest() {
    launched_.send_signal(SIGINT);
    launched_.wait(20s);
  }
  std::vector<msgs::JointState> states() const {
    const std::lock_guard lock(mutex_);
    return states_;
  }
  void clear() {
    const std::lock_guard lock(mutex_);
    states_.clear();
  }
  graph::Node& node() { return node_; }
  std::string output() const { return launched_.output(); }
  msgs::Acknowledge call(const std::string& service) {
    const auto outcome = node_.client<msgs::Empty, msgs::Acknowledge>(service).call({}, 10s);
    return outcome ? *outcome : msgs::Acknowledge{};
  }

 private:
  std::vector<std::string> arguments_of(const ArmKind& kind) const {
    std::vector<std::string> words{"launch", kind.launch_file};
    const int port = ntohs(kuka_rsi::UdpSocket("127.0.0.1", 0).here().address.sin_port);
    for (std::string argument : kind.arguments) {
      const auto at = argument.find("PORT");
      if (at != std::string::npos) argument.replace(at, 4, std::to_string(port));
      words.push_back(argument);
    }
    for (const std::string& word : {std::string("--registry"), registry_, std::string("--log-dir"),
                                    (scratch_.path() / "log").string()}) {
      words.push_back(word);
    }
    return words;
  }
  graph::NodeOptions options() const {
    graph::NodeOptions options;
    options.name = "contract";
    options.registry = registry_;
    options.clock = graph::ClockMode::kSimulated;
    options.registry_timeout = 30s;
    return options;
  }

  testing::ScratchFolder scratch_;
  std::string registry_;
  testing::Launched launched_;
  graph::Node node_;
  mutable std::mutex mutex_;
  std::vector<msgs::JointState> states_;

 public:
  graph::ActionClient<Goal, msgs::FollowTrajectoryFeedback, Result> follow;

 private:
  graph::Subscription joints_;
};

std::map<std::string, std::unique_ptr<ArmUnderTest>>& arms() {
  static std::map<std::string, std::unique_ptr<ArmUnderTest>> all;
  return all;
}
class StopArms : public ::testing::Environment {
  void TearDown() override { arms().clear(); }
};
const auto* const environment_of_arms = ::testing::AddGlobalTestEnvironment(new StopArms);

class ArmContract : public ::testing::TestWithParam<ArmKind> {
 protected:
  void SetUp() override {
    auto& arm = arms()[GetParam().name];
    if (!arm) arm = std::make_unique<ArmUnderTest>(GetParam());
    arm_ = arm.get();
    ASSERT_TRUE(eventually([&] { return !arm_->states().empty(); }, 40s)) << arm_->output();
    // Each test begins at home, standing.
    ASSERT_TRUE(eventually([&] { return stands(); }));
    ASSERT_TRUE(eventually([&] { return follow(turn(home() - position()[0], 3)).reached(); }, 60s))
        << arm_->output();
    arm_->clear();
    ASSERT_TRUE(eventually([&] { return !arm_->states().empty(); }));
  }
  static double home() { return 0; }  // of axis 1
  std::vector<double> position() const {
    const msgs::JointState state = arm_->states().back();
    return {state.position().begin(), state.position().begin() + 6};
  }
  double speed() const { return arm_->states().back().velocity(0); }
  bool stands() const {
    const auto all = arm_->states();
    if (all.size() < 20) return false;
    return std::all_of(all.end() - 20, all.end(),
                       [](const auto& state) { return std::abs(state.velocity(0)) < 1e-3; });
  }
  /// From where the arm stands, axis 1 by `way` in `duration`, from and to a stand.
  Goal turn(double way, double duration) const {
    Goal goal;
    const std::vector<double> from = position();
    for (int i = 1; i <= 6; ++i) {
      goal.mutable_trajectory()->add_joint_name("arm_axis_" + std::to_string(i));
    }
    for (const double share : {0.0, 1.0}) {
      msgs::JointTrajectoryPoint& point = *goal.mutable_trajectory()->add_points();
      point.set_time(share * duration);
      for (int i = 0; i < 6; ++i) {
        point.add_position(from[static_cast<std::size_t>(i)] + (i == 0 ? share * way : 0.0));
        point.add_velocity(0);
        point.add_acceleration(0);
      }
    }
    return goal;
  }
  Result follow(const Goal& goal) {
    const auto outcome = arm_->follow.send(goal).wait(60s);
    EXPECT_TRUE(outcome) << outcome.error();
    return outcome ? *outcome : Result();
  }
  void expect_refused(const Goal& goal, const std::string& words) {
    const std::vector<double> before = position();
    const Result result = follow(goal);
    EXPECT_FALSE(result.reached());
    EXPECT_THAT(result.reason(), HasSubstr(words));
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(position()[i], before[i], 1e-4);
  }
  ArmUnderTest* arm_ = nullptr;
};

TEST_P(ArmContract, JointStatesHaveNamesRateAndTheHand) {
  ASSERT_TRUE(eventually([&] { return arm_->states().size() >= 60; }));
  const auto states = arm_->states();
  for (std::size_t i = 1; i < states.size(); ++i) {
    ASSERT_GE(states[i].header().stamp(), states[i - 1].header().stamp());
  }
  const double span =
      1e-9 * static_cast<double>(states.back().header().stamp() - states.front().header().stamp());
  EXPECT_GE(static_cast<double>(states.size() - 1) / span, 25);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(states.back().name(i), "arm_axis_" + std::to_string(i + 1));
  }
  EXPECT_THAT(states.back().name(), ::testing::Contains("hand_opening"));
  EXPECT_EQ(states.back().position_size(), states.back().name_size());
  EXPECT_EQ(states.back().velocity_size(), states.back().name_size());
}

TEST_P(ArmContract, FollowsATrajectoryAndTellsHowFarItIs) {
  std::atomic<int> feedbacks = 0;
  const auto handle =
      arm_->follow.send(turn(0.4, 1.5), [&](const msgs::FollowTrajectoryFeedback& feedback) {
        feedbacks += feedback.desired_size() == 6 && feedback.actual_size() == 6;
      });
  const auto outcome = handle.wait(60s);
  ASSERT_TRUE(outcome) << outcome.error();
  EXPECT_TRUE(outcome->reached()) << outcome->reason();
  EXPECT_NEAR(outcome->position(0), home() + 0.4, 3e-3);
  EXPECT_GE(feedbacks, 2);
  double fastest = 0;
  for (const auto& state : arm_->states()) fastest = std::max(fastest, state.velocity(0));
  EXPECT_GT(fastest, 0.3);  // the quintic's 1.875 * 0.4 / 1.5 = 0.5 rad/s at its middle
}

TEST_P(ArmContract, RefusesTrajectoriesThatCannotBeRightInWords) {
  Goal goal = turn(0.4, 2);
  goal.mutable_trajectory()->set_joint_name(2, "arm_axis_33");
  expect_refused(goal, "did you mean \"arm_axis_3\"?");
  goal = turn(0.4, 2);
  goal.mutable_trajectory()->mutable_points(0)->set_position(1, position()[1] + 0.1);
  expect_refused(goal, "plan from the arm's present positions");
  goal = turn(0.4, 2);
  goal.mutable_trajectory()->mutable_points(1)->set_position(
      3, std::numeric_limits<double>::quiet_NaN());
  expect_refused(goal, "no finite number");
  expect_refused(turn(4, 20), "is outside");
  goal = turn(0.4, 2);
  goal.mutable_trajectory()->mutable_points(1)->set_velocity(0, 50);
  expect_refused(goal, "is faster than");
  goal = turn(0.4, 2);
  goal.add_path_tolerance(-1);
  expect_refused(goal, "path_tolerance");
  goal = turn(0.4, 2);
  goal.set_stop_on_contact(true);
  expect_refused(goal, "contact_force must be positive");
  goal = turn(0.4, 2);
  goal.mutable_trajectory()->clear_points();
  expect_refused(goal, "no points");
}

TEST_P(ArmContract, CancelledGoalBrakesTheArm) {
  const auto handle = arm_->follow.send(turn(1.0, 4));
  ASSERT_TRUE(eventually([&] { return speed() > 0.2; }));
  handle.cancel();
  EXPECT_EQ(handle.wait(20s).status(), graph::Status::kCancelled);
  EXPECT_TRUE(eventually([&] { return stands(); }));
  EXPECT_LT(position()[0], home() + 0.95);
}

TEST_P(ArmContract, NewerGoalBeginsWhereTheArmThenStands) {
  const auto first = arm_->follow.send(turn(1.0, 4));
  ASSERT_TRUE(eventually([&] { return position()[0] > home() + 0.15; }));
  const Goal late = turn(-3.0, 9);
  const double planned_at = position()[0];
  ASSERT_TRUE(eventually([&] { return position()[0] > planned_at + 0.1; }));
  const Result second = follow(late);  // planned from elsewhere
  EXPECT_FALSE(second.reached());
  EXPECT_EQ(first.wait(20s).status(), graph::Status::kPreempted);
  EXPECT_TRUE(eventually([&] { return stands(); }));
  // On a starved machine it may seem to stand while no telegram comes, and is refused then.
  double from = 0;
  Result third;
  EXPECT_TRUE(eventually([&] {
    from = position()[0];
    third = follow(turn(-0.1, 1));
    return third.reached() ||
           third.reason().find("plan from the arm's present positions") == std::string::npos;
  }));
  EXPECT_TRUE(third.reached()) << third.reason();
  EXPECT_NEAR(third.position(0), from - 0.1, 4e-3);
}

TEST_P(ArmContract, StopsWhenAsked) {
  const auto handle = arm_->follow.send(turn(1.0, 4));
  ASSERT_TRUE(eventually([&] { return speed() > 0.2; }));
  EXPECT_TRUE(arm_->call("/arm/stop").success());
  const auto outcome = handle.wait(20s);
  ASSERT_TRUE(outcome) << outcome.error();
  EXPECT_FALSE(outcome->reached());
  EXPECT_EQ(outcome->reason(), "stopped before the goal");
  EXPECT_TRUE(eventually([&] { return stands(); }));
  EXPECT_LT(position()[0], home() + 0.95);
}

/// Of drivers: a simulation offers no fast stop.
class ArmDriverContract : public ArmContract {};

TEST_P(ArmDriverContract, FastStopHoldsUntilItIsAcknowledged) {
  const auto handle = arm_->follow.send(turn(1.0, 4));
  ASSERT_TRUE(eventually([&] { return speed() > 0.2; }));
  EXPECT_TRUE(arm_->call("/arm/fast_stop").success());
  EXPECT_THAT(handle.wait(20s)->reason(), HasSubstr("/arm/fast_stop"));
  EXPECT_TRUE(eventually([&] { return stands(); }));
  expect_refused(turn(0.1, 1), "acknowledge it first");
  EXPECT_TRUE(arm_->call("/arm/acknowledge").success());
  EXPECT_FALSE(arm_->call("/arm/acknowledge").success());
}

const ArmKind kSimulation{"Simulation", "launch/bringup.yaml", {"platform:=kr5_pg70"}};
const ArmKind kEmulatedRsi{"EmulatedRsi",
                           "launch/emulated_robot.yaml",
                           {"platform:=kr5_pg70", "arm:=rsi", "rsi_port:=PORT"}};
const ArmKind kEmulatedRsi3{
    "EmulatedRsi3",
    "launch/emulated_robot.yaml",
    {"platform:=kr5_pg70", "arm:=rsi", "rsi_port:=PORT", "rsi:=3", "rsi_cycle:=4"}};

INSTANTIATE_TEST_SUITE_P(Arms, ArmContract,
                         ::testing::Values(kSimulation, kEmulatedRsi, kEmulatedRsi3),
                         [](const auto& kind) { return kind.param.name; });
INSTANTIATE_TEST_SUITE_P(Drivers, ArmDriverContract, ::testing::Values(kEmulatedRsi, kEmulatedRsi3),
                         [](const auto& kind) { return kind.param.name; });

}  // namespace
}  // namespace prehend::drivers
