// What every hand offers, be it simulated, an SDH-2 over a serial line or TCP, or a BarrettHand
// over CAN or a serial line: the topics, the action, its results and words of refusal, stops, pads.

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

/// What of the contract is the hand's own.
struct HandFacts {
  std::string platform;
  std::vector<std::string> motors, arm_joints;
  std::vector<std::string> fingers;  // that close by positive positions, together and alone
  std::string lone;                  // one that moves with nothing in its way
  double lone_speed = 0;             // rad/s, its greatest
  std::string streamed;              // another such one, that a stream moves
  std::vector<double> there;         // rad, of the motors, within their limits
  std::vector<double> pressing;      // where fingers meet each other on the way
  std::size_t pressed = 0;           // a motor that is stopped by that,
  double least = 0, most = 0;        // rad, between these
  double back = 0;                   // rad: whereto the first finger may be called back
  struct Pad {
    std::string name;
    unsigned rows, columns;
  };
  std::vector<Pad> pads;
};

const HandFacts kSdh2{.platform = "kr5_sdh",
                      .motors = {"pivot", "finger_1_proximal", "finger_1_distal", "thumb_proximal",
                                 "thumb_distal", "finger_2_proximal", "finger_2_distal"},
                      .arm_joints = {"axis_1", "axis_2", "axis_3", "axis_4", "axis_5", "axis_6"},
                      .fingers = {"finger_1_proximal", "finger_2_proximal", "thumb_proximal"},
                      .lone = "thumb_proximal",
                      .lone_speed = 2.45,  // 140 degree/s
                      .streamed = "thumb_distal",
                      .there = {0.6, -0.3, 0.4, -0.35, 0.2, -0.15, 0.25},
                      .pressing = {0.6, -0.3, 0.4, 0.35, -0.2, 0.15, 0.25},
                      .pressed = 3,
                      .least = 0.05,
                      .most = 0.33,
                      .back = -0.2,
                      .pads = {{"finger_1_proximal", 14, 6},
                               {"finger_1_distal", 13, 6},
                               {"thumb_proximal", 14, 6},
                               {"thumb_distal", 13, 6},
                               {"finger_2_proximal", 14, 6},
                               {"finger_2_distal", 13, 6}}};

const HandFacts kBarrett{
    .platform = "pa10_barrett",
    .motors = {"finger_1_inner", "finger_2_inner", "finger_3_inner", "spread"},
    .arm_joints = {"s1", "s2", "s3", "e1", "e2", "w1", "w2"},
    .fingers = {"finger_1_inner", "finger_2_inner", "finger_3_inner"},
    .lone = "finger_3_inner",
    .lone_speed = 2,
    .streamed = "finger_3_inner",
    .there = {0.6, 0.5, 0.4, 0.3},
    .pressing = {2.3, 2.3, 0.1, 1.5707963},
    .pressed = 0,
    .least = 1,
    .most = 2.2,
    .back = 0,
    .pads = {{"fingertip_1", 8, 3}, {"fingertip_2", 8, 3}, {"fingertip_3", 8, 3}, {"palm", 7, 4}}};

// The same hand with another controller, and no pads.
const HandFacts kBarrett262 = [] {
  HandFacts facts = kBarrett;
  facts.pads.clear();
  return facts;
}();

struct HandKind : RobotKind {
  const HandFacts* facts = nullptr;
};

/// Simulation and emulated hands; a real one when PREHEND_HAND holds the arguments of
/// launch/bringup.yaml, e.g. "hand:=sdh sdh:=/dev/ttyUSB2 tactile:=dsa". Nothing may be between its
/// fingers then, and its arm is the simulation's.
std::vector<HandKind> hand_kinds() {
  const std::string emulated = "launch/emulated_robot.yaml", bringup = "launch/bringup.yaml";
  const std::string sdh = "platform:=kr5_sdh", barrett = "platform:=pa10_barrett";
  const std::string lines = "lines:=LINES/line";
  std::vector<HandKind> kinds{
      {{"Simulation", bringup, {sdh}}, &kSdh2},
      {{"EmulatedSerial", emulated, {sdh, "hand:=sdh", "tactile:=dsa", lines}}, &kSdh2},
      {{"EmulatedTcp",
        emulated,
        {sdh, "hand:=sdh", "tactile:=dsa", lines, "sdh_port:=PORT", "hand_profile:=sine_square"}},
       &kSdh2},
      {{"SimulatedBarrett", bringup, {barrett}}, &kBarrett},
      {{"EmulatedBarrett", emulated, {barrett, "hand:=barrett", lines}}, &kBarrett},
      {{"EmulatedBarrett262",
        emulated,
        {barrett, "hand:=barrett", "barrett_model:=bh8_262", "barrett_fast_baud:=38400", lines}},
       &kBarrett262}};
  if (const char* hardware = std::getenv("PREHEND_HAND")) {
    std::istringstream words(hardware);
    HandKind real{{"Hardware", bringup, {}}, &kSdh2};
    for (std::string word; words >> word;) {
      if (word == "hand:=barrett") real.facts = &kBarrett;
      if (word == "barrett_model:=bh8_262") real.facts = &kBarrett262;
      real.arguments.push_back(word);
    }
    real.arguments.insert(real.arguments.begin(), "platform:=" + real.facts->platform);
    kinds.push_back(real);
  }
  return kinds;
}

/// The running hand, and a node that uses it.
class HandUnderTest {
 public:
  explicit HandUnderTest(const HandKind& kind)
      : registry_(TcpServer().name()),
        launched_("prehend", arguments_of(kind), scratch_.path() / "output.txt"),
        node_(options_of(kind)),
        move(node_.action_client<Goal, msgs::MoveHandFeedback, Result>("/hand/move")),
        commands(node_.advertise<msgs::JointCommand>("/hand/command", graph::QoS::queue(10))),
        states(node_, "/joint_states") {
    for (const HandFacts::Pad& pad : kind.facts->pads) {
      pads.push_back(std::make_unique<TopicLog<msgs::TactileFrame>>(node_, "/tactile/" + pad.name));
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

class HandContract : public ::testing::TestWithParam<HandKind> {
 protected:
  void SetUp() override {
    auto& hand = hands()[GetParam().name];
    if (!hand) hand = std::make_unique<HandUnderTest>(GetParam());
    hand_ = hand.get();
    ASSERT_TRUE(eventually([&] { return hand_->states.size() > 0; }, 40s)) << hand_->output();
    // Each test begins with straight fingers, standing.
    ASSERT_TRUE(eventually([&] { return stands(); }, 20s));
    const Result there = move(straight());
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
  static const HandFacts& facts() { return *GetParam().facts; }
  static Goal straight(double speed = 1) {
    return goal(facts().motors, std::vector<double>(facts().motors.size(), 0.0), speed);
  }
  static const std::string& finger() { return facts().fingers.front(); }
  /// The three fingers inwards, slowly: some two seconds.
  static Goal slow_goal() { return goal(facts().fingers, {0.5, 0.5, 0.5}, 0.1); }
  Result move(const Goal& goal) {
    const auto outcome = hand_->move.send(goal).wait(60s);
    EXPECT_TRUE(outcome) << outcome.error();
    return outcome ? *outcome : Result();
  }
  double value(const std::string& joint) const {
    const msgs::JointState state = hand_->states.last();
    for (int i = 0; i < state.name_size(); ++i) {
      if (state.name(i) == "hand_" + joint) return state.position(i);
    }
    ADD_FAILURE() << "/joint_states has no hand_" << joint;
    return 0;
  }
  /// Mean speed of `joint` on the way from one position to another, rad/s. Single readings' rates
  /// are off by a half where the machine holds up the one who reads.
  double speed_between(const std::string& joint, double from, double to) const {
    double first = -1, last = -1, began = 0, ended = 0;  // rad and s
    for (const auto& state : hand_->states.all()) {
      for (int i = 0; i < state.name_size(); ++i) {
        if (state.name(i) != "hand_" + joint || state.position(i) < from || last >= to) continue;
        last = state.position(i);
        ended = 1e-9 * static_cast<double>(state.header().stamp());
        if (first < 0) {
          first = last;
          began = ended;
        }
      }
    }
    EXPECT_GE(last, to) << joint << " is not seen to pass";
    EXPECT_GT(ended, began);
    return (last - first) / (ended - began);
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
    return eventually([&] { return value(finger()) > 0.05; }, 20s);
  }
  void expect_refused(const Goal& goal, const std::string& words) {
    const Result result = move(goal);
    EXPECT_FALSE(result.reached());
    EXPECT_THAT(result.reason(), HasSubstr(words));
    for (const std::string& joint : facts().motors) EXPECT_NEAR(value(joint), 0, 0.02) << joint;
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
  for (const std::string& joint : facts().motors) {
    EXPECT_THAT(states.back().name(), ::testing::Contains("hand_" + joint));
  }
  for (const std::string& joint : facts().arm_joints) {
    EXPECT_THAT(states.back().name(), ::testing::Contains("arm_" + joint));
  }
  EXPECT_EQ(states.back().position_size(), states.back().name_size());
  EXPECT_EQ(states.back().velocity_size(), states.back().name_size());
}

TEST_P(HandContract, GoesThereAndTellsHowFarItIs) {
  std::atomic<int> feedbacks = 0;
  const std::vector<double>& there = facts().there;
  Goal wanted = goal(facts().motors, there, 0.3);
  wanted.set_joint_name(1, "hand_" + facts().motors[1]);  // the platform's name does, too
  const int count = static_cast<int>(there.size());
  const auto outcome =
      hand_->move
          .send(wanted,
                [&](const msgs::MoveHandFeedback& f) { feedbacks += f.position_size() == count; })
          .wait(60s);
  ASSERT_TRUE(outcome) << outcome.error();
  EXPECT_TRUE(outcome->reached()) << outcome->reason();
  EXPECT_FALSE(outcome->blocked());
  EXPECT_EQ(outcome->reason(), "");
  ASSERT_EQ(outcome->position_size(), count);
  EXPECT_GE(feedbacks, 2);
  hand_->states.clear();
  ASSERT_TRUE(eventually([&] { return stands(); }, 20s));
  for (std::size_t i = 0; i < there.size(); ++i) {
    EXPECT_NEAR(outcome->position(static_cast<int>(i)), there[i], 0.02) << facts().motors[i];
    EXPECT_NEAR(value(facts().motors[i]), there[i], 0.02) << facts().motors[i];
  }
}

// Fingers that meet each other on the way.
TEST_P(HandContract, FingersPressWhereSomethingIsInTheWay) {
  Goal wanted = goal(facts().motors, facts().pressing, 0.2);
  wanted.set_until_contact(true);
  for (std::size_t i = 0; i < facts().motors.size(); ++i) wanted.add_effort(0.5);
  const Result result = move(wanted);
  EXPECT_TRUE(result.blocked()) << result.reason();
  EXPECT_FALSE(result.reached());
  EXPECT_EQ(result.reason(), "pressing");
  ASSERT_EQ(result.position_size(), static_cast<int>(facts().motors.size()));
  EXPECT_LT(result.position(static_cast<int>(facts().pressed)), facts().most);
  EXPECT_GT(result.position(static_cast<int>(facts().pressed)), facts().least);
  // They let go again.
  EXPECT_TRUE(move(straight(0.5)).reached());
}

TEST_P(HandContract, SpeedIsAShareOfTheGreatest) {
  std::vector<double> speeds;
  for (const double share : {0.1, 0.3}) {
    hand_->states.clear();
    const Result there = move(goal({facts().lone}, {0.6}, share));
    ASSERT_TRUE(there.reached()) << there.reason() << hand_->output();
    speeds.push_back(speed_between(facts().lone, 0.1, 0.5));
    const Result back = move(goal({facts().lone}, {0.0}, 1));
    ASSERT_TRUE(back.reached()) << back.reason() << hand_->output();
  }
  EXPECT_LT(speeds[0], 0.1 * facts().lone_speed * 1.3);
  EXPECT_LT(speeds[1], 0.3 * facts().lone_speed * 1.3);
  EXPECT_GT(speeds[1], 1.5 * speeds[0]);
}

TEST_P(HandContract, RefusesGoalsThatCannotBeRightInWords) {
  const std::string &joint = facts().motors.front(), &other = facts().streamed;
  expect_refused({}, "the goal names no joint");
  expect_refused(goal({joint}, {}, 1), "0 positions for 1 joints");
  expect_refused(goal({joint + "t"}, {0.1}, 1), "the hand has no motor '" + joint + "t'");
  expect_refused(goal({joint, joint}, {0.1, 0.1}, 1), "joint '" + joint + "' is named twice");
  expect_refused(goal({joint}, {0.1}, 0), "speed");
  expect_refused(goal({joint}, {0.1}, 1.5), "speed");
  expect_refused(goal({joint}, {std::numeric_limits<double>::quiet_NaN()}, 1), "finite");
  expect_refused(goal({other}, {3.0}, 1), other + "' at 3.0000 is outside");
  Goal strong = goal({other}, {0.1}, 1);
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
  EXPECT_LT(value(finger()), 0.45);
}

TEST_P(HandContract, NewerGoalTakesTheHandOver) {
  const auto first = hand_->move.send(slow_goal());
  ASSERT_TRUE(begins_to_close());
  const Result second = move(goal({finger()}, {facts().back}, 0.5));
  EXPECT_TRUE(second.reached()) << second.reason();
  EXPECT_NEAR(value(finger()), facts().back, 0.03);
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
  EXPECT_LT(value(finger()), 0.45);
}

TEST_P(HandContract, SpeedsOfAStreamAreFollowedAndEndWithIt) {
  ASSERT_TRUE(eventually(
      [&] {
        hand_->command(msgs::JointCommand::VELOCITY, finger(), 0.15);
        return value(finger()) > 0.1;
      },
      20s));
  EXPECT_NEAR(value(facts().lone), 0, 0.02);
  hand_->states.clear();
  EXPECT_TRUE(eventually([&] { return stands(); }, 20s));
  EXPECT_LT(value(finger()), 0.6);
}

TEST_P(HandContract, PositionsOfAStreamAreGoneTo) {
  ASSERT_TRUE(eventually(
      [&] {
        hand_->command(msgs::JointCommand::POSITION, facts().streamed, 0.3);
        return std::abs(value(facts().streamed) - 0.3) < 0.02;
      },
      20s));
  hand_->command(msgs::JointCommand::POSITION, facts().streamed, 9);
  hand_->states.clear();
  EXPECT_TRUE(eventually([&] { return stands(); }, 20s));
  EXPECT_NEAR(value(facts().streamed), 0.3, 0.03);
}

TEST_P(HandContract, PadsHaveTheirTexels) {
  if (facts().pads.empty()) {
    EXPECT_THAT(hand_->output(), HasSubstr("no pads"));
  }
  for (std::size_t i = 0; i < facts().pads.size(); ++i) {
    const HandFacts::Pad& pad = facts().pads[i];
    ASSERT_TRUE(eventually([&] { return hand_->pads[i]->size() > 2; }, 20s)) << pad.name;
    const msgs::TactileFrame frame = hand_->pads[i]->last();
    EXPECT_EQ(frame.columns(), pad.columns) << pad.name;
    EXPECT_EQ(frame.rows(), pad.rows) << pad.name;
    EXPECT_EQ(frame.intensity_size(), static_cast<int>(pad.rows * pad.columns)) << pad.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Hands, HandContract, ::testing::ValuesIn(hand_kinds()),
                         [](const auto& kind) { return kind.param.name; });

}  // namespace
}  // namespace prehend::drivers
