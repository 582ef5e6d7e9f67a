// What every hand of seven joints offers, be it simulated or an SDH-2 over a serial line or TCP:
// the topics, the action, its results and words of refusal, stops, six pads.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/drivers/contract/robot_under_test.h"

namespace prehend::drivers {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Goal = msgs::MoveHandGoal;
using Result = msgs::MoveHandResult;

const std::vector<std::string> kMotors{"pivot",          "finger_1_proximal", "finger_1_distal",
                                       "thumb_proximal", "thumb_distal",      "finger_2_proximal",
                                       "finger_2_distal"};
const std::vector<std::string> kPads{"finger_1_proximal", "finger_1_distal",   "thumb_proximal",
                                     "thumb_distal",      "finger_2_proximal", "finger_2_distal"};

/// Simulation and emulated hands; a real one when PREHEND_HAND holds the arguments of
/// launch/bringup.yaml, e.g. "hand:=sdh sdh:=/dev/ttyUSB2 tactile:=dsa". Nothing may be between its
/// fingers then, and its arm is the simulation's.
std::vector<RobotKind> hand_kinds() {
  std::vector<RobotKind> kinds{
      {"Simulation", "launch/bringup.yaml", {"platform:=kr5_sdh"}},
      {"EmulatedSerial",
       "launch/emulated_robot.yaml",
       {"platform:=kr5_sdh", "hand:=sdh", "tactile:=dsa", "lines:=LINES/line"}},
      {"EmulatedTcp",
       "launch/emulated_robot.yaml",
       {"platform:=kr5_sdh", "hand:=sdh", "tactile:=dsa", "lines:=LINES/line", "sdh_port:=PORT",
        "hand_profile:=sine_square"}}};
  if (const char* hardware = std::getenv("PREHEND_HAND")) {
    RobotKind real{"Hardware", "launch/bringup.yaml", {"platform:=kr5_sdh"}};
    std::istringstream words(hardware);
    for (std::string word; words >> word;) real.arguments.push_back(word);
    kinds.push_back(real);
  }
  return kinds;
}

/// The running hand, and a node that uses it.
class HandUnderTest {
 public:
  explicit HandUnderTest(const RobotKind& kind)
      : registry_(TcpServer().name()),
        launched_("prehend", arguments_of(kind), scratch_.path() / "output.txt"),
        node_(options_of(kind)),
        move(node_.action_client<Goal, msgs::MoveHandFeedback, Result>("/hand/move")),
        commands(node_.advertise<msgs::JointCommand>("/hand/command", graph::QoS::queue(10))),
        states(node_, "/joint_states") {
    for (const std::string& pad : kPads) {
      pads.push_back(std::make_unique<TopicLog<msgs::TactileFrame>>(node_, "/tactile/" + pad));
    }
    node_.spin_in_background();
  }
  ~HandUnderTest() {
    launched_.send_signal(SIGINT);
    launched_.wait(20s);
  }
  void command(msgs::JointCommand::Mode mode, const std::string& joint, double value) {
    msgs::JointCommand message;
    message.mutable_header()->set_stamp(node_.clock().now());
    message.set_mode(mode);
    message.add_joint_name(joint);
    message.add_value(value);
    commands.publish(message);
  }
  std::string output() const { return launched_.output(); }
  msgs::Acknowledge call(const std::string& service) {
    const auto outcome = node_.client<msgs::Empty, msgs::Acknowledge>(service).call({}, 10s);
    return outcome ? *outcome : msgs::Acknowledge{};
  }

 private:
  std::vector<std::string> arguments_of(const RobotKind& kind) const {
    std::vector<std::string> words{"launch", kind.launch_file};
    const std::string port_name = TcpServer().name();
    const std::string port = port_name.substr(port_name.rfind(':') + 1);
    for (std::string argument : kind.arguments) {
      for (const auto& [word, value] :
           {std::pair<std::string, std::string>{"LINES", scratch_.path()}, {"PORT", port}}) {
        const auto at = argument.find(word);
        if (at != std::string::npos) argument.replace(at, word.size(), value);
      }
      words.push_back(argument);
    }
    for (const std::string& word : {std::string("--registry"), registry_, std::string("--log-dir"),
                                    (scratch_.path() / "log").string()}) {
      words.push_back(word);
    }
    return words;
  }
  graph::NodeOptions options_of(const RobotKind& kind) const {
    graph::NodeOptions options;
    options.name = "contract";
    options.registry = registry_;
    options.clock = kind.clock();
    options.registry_timeout = 30s;
    return options;
  }

  testing::ScratchFolder scratch_;
  std::string registry_;
  testing::Launched launched_;
  graph::Node node_;

 public:
  graph::ActionClient<Goal, msgs::MoveHandFeedback, Result> move;
  graph::Publisher<msgs::JointCommand> commands;
  TopicLog<msgs::JointState> states;
  std::vector<std::unique_ptr<TopicLog<msgs::TactileFrame>>> pads;
};

std::map<std::string, std::unique_ptr<HandUnderTest>>& hands() {
  static std::map<std::string, std::unique_ptr<HandUnderTest>> all;
  return all;
}
class StopHands : public ::testing::Environment {
  void TearDown() override { hands().clear(); }
};
const auto* const environment_of_hands = ::testing::AddGlobalTestEnvironment(new StopHands);

class HandContract : public ::testing::TestWithParam<RobotKind> {
 protected:
  void SetUp() override {
    auto& hand = hands()[GetParam().name];
    if (!hand) hand = std::make_unique<HandUnderTest>(GetParam());
    hand_ = hand.get();
    ASSERT_TRUE(eventually([&] { return hand_->states.size() > 0; }, 40s)) << hand_->output();
    // Each test begins with straight fingers, standing.
    ASSERT_TRUE(eventually([&] { return stands(); }, 20s));
    Goal straight = goal(kMotors, std::vector<double>(kMotors.size(), 0.0), 1);
    const Result there = move(straight);
    ASSERT_TRUE(there.reached()) << there.reason() << hand_->output();
    hand_->states.clear();
    ASSERT_TRUE(eventually([&] { return hand_->states.size() > 0; }));
  }
  static Goal goal(const std::vector<std::string>& joints, const std::vector<double>& positions,
                   double speed) {
    Goal goal;
    for (const std::string& joint : joints) goal.add_joint_name(joint);
    for (const double position : positions) goal.add_position(position);
    goal.set_speed(speed);
    return goal;
  }
  /// The three proximal joints inwards, slowly: some two seconds.
  static Goal slow_goal() {
    return goal({"finger_1_proximal", "finger_2_proximal", "thumb_proximal"}, {0.5, 0.5, 0.5}, 0.1);
  }
  Result move(const Goal& goal) {
    const auto outcome = hand_->move.send(goal).wait(60s);
    EXPECT_TRUE(outcome) << outcome.error();
    return outcome ? *outcome : Result();
  }
  double value(const std::string& joint, bool rate = false) const {
    const msgs::JointState state = hand_->states.last();
    for (int i = 0; i < state.name_size(); ++i) {
      if (state.name(i) == "hand_" + joint) return rate ? state.velocity(i) : state.position(i);
    }
    ADD_FAILURE() << "/joint_states has no hand_" << joint;
    return 0;
  }
  bool stands() const {
    const auto all = hand_->states.all();
    if (all.size() < 20) return false;
    return std::all_of(all.end() - 20, all.end(), [](const msgs::JointState& state) {
      for (int i = 0; i < state.name_size(); ++i) {
        if (state.name(i).starts_with("hand_") && std::abs(state.velocity(i)) > 5e-3) return false;
      }
      return true;
    });
  }
  bool begins_to_close() {
    return eventually([&] { return value("finger_1_proximal") > 0.05; }, 20s);
  }
  void expect_refused(const Goal& goal, const std::string& words) {
    const Result result = move(goal);
    EXPECT_FALSE(result.reached());
    EXPECT_THAT(result.reason(), HasSubstr(words));
    for (const std::string& joint : kMotors) EXPECT_NEAR(value(joint), 0, 0.02) << joint;
  }
  HandUnderTest* hand_ = nullptr;
};

TEST_P(HandContract, JointStatesHaveHandAndArmTwentyTimesASecond) {
  ASSERT_TRUE(eventually([&] { return hand_->states.size() >= 60; }, 20s));
  const auto states = hand_->states.all();
  for (std::size_t i = 1; i < states.size(); ++i) {
    ASSERT_GE(states[i].header().stamp(), states[i - 1].header().stamp());
  }
  const double span =
      1e-9 * static_cast<double>(states.back().header().stamp() - states.front().header().stamp());
  EXPECT_GE(static_cast<double>(states.size() - 1) / span, 18);
  for (const std::string& joint : kMotors) {
    EXPECT_THAT(states.back().name(), ::testing::Contains("hand_" + joint));
  }
  for (int i = 1; i <= 6; ++i) {
    EXPECT_THAT(states.back().name(), ::testing::Contains("arm_axis_" + std::to_string(i)));
  }
  EXPECT_EQ(states.back().position_size(), states.back().name_size());
  EXPECT_EQ(states.back().velocity_size(), states.back().name_size());
}

TEST_P(HandContract, GoesThereAndTellsHowFarItIs) {
  std::atomic<int> feedbacks = 0;
  const std::vector<double> there{0.6, -0.3, 0.4, -0.35, 0.2, -0.15, 0.25};
  Goal wanted = goal(kMotors, there, 0.3);
  wanted.set_joint_name(1, "hand_finger_1_proximal");  // the platform's name does, too
  const auto outcome =
      hand_->move
          .send(wanted,
                [&](const msgs::MoveHandFeedback& f) { feedbacks += f.position_size() == 7; })
          .wait(60s);
  ASSERT_TRUE(outcome) << outcome.error();
  EXPECT_TRUE(outcome->reached()) << outcome->reason();
  EXPECT_FALSE(outcome->blocked());
  EXPECT_EQ(outcome->reason(), "");
  ASSERT_EQ(outcome->position_size(), 7);
  EXPECT_GE(feedbacks, 2);
  hand_->states.clear();
  ASSERT_TRUE(eventually([&] { return stands(); }, 20s));
  for (std::size_t i = 0; i < there.size(); ++i) {
    EXPECT_NEAR(outcome->position(static_cast<int>(i)), there[i], 0.02) << kMotors[i];
    EXPECT_NEAR(value(kMotors[i]), there[i], 0.02) << kMotors[i];
  }
}

// Fingers that meet each other on the way.
TEST_P(HandContract, FingersPressWhereSomethingIsInTheWay) {
  Goal wanted = goal(kMotors, {0.6, -0.3, 0.4, 0.35, -0.2, 0.15, 0.25}, 0.2);
  wanted.set_until_contact(true);
  for (std::size_t i = 0; i < kMotors.size(); ++i) wanted.add_effort(0.5);
  const Result result = move(wanted);
  EXPECT_TRUE(result.blocked()) << result.reason();
  EXPECT_FALSE(result.reached());
  EXPECT_EQ(result.reason(), "pressing");
  ASSERT_EQ(result.position_size(), 7);
  EXPECT_LT(result.position(3), 0.33);
  EXPECT_GT(result.position(3), 0.05);
  // They let go again.
  EXPECT_TRUE(move(goal(kMotors, std::vector<double>(kMotors.size(), 0.0), 0.5)).reached());
}

TEST_P(HandContract, SpeedIsAShareOfTheGreatest) {
  std::vector<double> fastest;
  for (const double share : {0.1, 0.3}) {
    hand_->states.clear();
    ASSERT_TRUE(move(goal({"thumb_proximal"}, {0.6}, share)).reached());
    double most = 0;
    for (const auto& state : hand_->states.all()) {
      for (int i = 0; i < state.name_size(); ++i) {
        if (state.name(i) == "hand_thumb_proximal") most = std::max(most, state.velocity(i));
      }
    }
    fastest.push_back(most);
    ASSERT_TRUE(move(goal({"thumb_proximal"}, {0.0}, 1)).reached());
  }
  EXPECT_LT(fastest[0], 0.1 * 2.45 * 1.3);  // 140 degree/s
  EXPECT_LT(fastest[1], 0.3 * 2.45 * 1.3);
  EXPECT_GT(fastest[1], 1.5 * fastest[0]);
}

TEST_P(HandContract, RefusesGoalsThatCannotBeRightInWords) {
  expect_refused({}, "the goal names no joint");
  expect_refused(goal({"pivot"}, {}, 1), "0 positions for 1 joints");
  expect_refused(goal({"pivott"}, {0.1}, 1), "the hand has no motor 'pivott'");
  expect_refused(goal({"pivot", "pivot"}, {0.1, 0.1}, 1), "joint 'pivot' is named twice");
  expect_refused(goal({"pivot"}, {0.1}, 0), "speed");
  expect_refused(goal({"pivot"}, {0.1}, 1.5), "speed");
  expect_refused(goal({"pivot"}, {std::numeric_limits<double>::quiet_NaN()}, 1), "finite");
  expect_refused(goal({"thumb_distal"}, {3.0}, 1), "thumb_distal' at 3.0000 is outside");
  Goal strong = goal({"thumb_distal"}, {0.1}, 1);
  strong.add_effort(1e3);
  expect_refused(strong, "effort");
  strong.add_effort(0.1);
  expect_refused(strong, "2 efforts for 1 joints");
}

TEST_P(HandContract, CancelledGoalStopsTheHand) {
  const auto handle = hand_->move.send(slow_goal());
  ASSERT_TRUE(begins_to_close());
  handle.cancel();
  EXPECT_EQ(handle.wait(20s).status(), graph::Status::kCancelled);
  EXPECT_TRUE(eventually([&] { return stands(); }, 20s));
  EXPECT_LT(value("finger_1_proximal"), 0.45);
}

TEST_P(HandContract, NewerGoalTakesTheHandOver) {
  const auto first = hand_->move.send(slow_goal());
  ASSERT_TRUE(begins_to_close());
  const Result second = move(goal({"finger_1_proximal"}, {-0.2}, 0.5));
  EXPECT_TRUE(second.reached()) << second.reason();
  EXPECT_NEAR(value("finger_1_proximal"), -0.2, 0.03);
  EXPECT_EQ(first.wait(20s).status(), graph::Status::kPreempted);
}

TEST_P(HandContract, StopsWhenAsked) {
  const auto handle = hand_->move.send(slow_goal());
  ASSERT_TRUE(begins_to_close());
  EXPECT_TRUE(hand_->call("/hand/stop").success());
  const auto outcome = handle.wait(20s);
  ASSERT_TRUE(outcome) << outcome.error();
  EXPECT_FALSE(outcome->reached());
  EXPECT_EQ(outcome->reason(), "stopped by /hand/stop");
  EXPECT_TRUE(eventually([&] { return stands(); }, 20s));
  EXPECT_LT(value("finger_1_proximal"), 0.45);
}

TEST_P(HandContract, SpeedsOfAStreamAreFollowedAndEndWithIt) {
  ASSERT_TRUE(eventually(
      [&] {
        hand_->command(msgs::JointCommand::VELOCITY, "finger_1_proximal", 0.15);
        return value("finger_1_proximal") > 0.1;
      },
      20s));
  EXPECT_NEAR(value("thumb_proximal"), 0, 0.02);
  hand_->states.clear();
  EXPECT_TRUE(eventually([&] { return stands(); }, 20s));
  EXPECT_LT(value("finger_1_proximal"), 0.6);
}

TEST_P(HandContract, PositionsOfAStreamAreGoneTo) {
  ASSERT_TRUE(eventually(
      [&] {
        hand_->command(msgs::JointCommand::POSITION, "thumb_distal", 0.3);
        return std::abs(value("thumb_distal") - 0.3) < 0.02;
      },
      20s));
  hand_->command(msgs::JointCommand::POSITION, "thumb_distal", 9);
  hand_->states.clear();
  EXPECT_TRUE(eventually([&] { return stands(); }, 20s));
  EXPECT_NEAR(value("thumb_distal"), 0.3, 0.03);
}

TEST_P(HandContract, SixPadsHaveTheirTexels) {
  for (std::size_t i = 0; i < kPads.size(); ++i) {
    ASSERT_TRUE(eventually([&] { return hand_->pads[i]->size() > 2; }, 20s)) << kPads[i];
    const msgs::TactileFrame frame = hand_->pads[i]->last();
    EXPECT_EQ(frame.columns(), 6) << kPads[i];
    EXPECT_EQ(frame.rows(), i % 2 == 0 ? 14 : 13) << kPads[i];
  }
}

INSTANTIATE_TEST_SUITE_P(Hands, HandContract, ::testing::ValuesIn(hand_kinds()),
                         [](const auto& kind) { return kind.param.name; });

}  // namespace
}  // namespace prehend::drivers
