// What every robot offers, be it simulated, emulated or real: topics, units, rates, results, words
// of refusal, watchdog, limits.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "msgs/convert/geometry.h"
#include "prehend/geometry/triangle_mesh.h"
#include "tests/drivers/contract/robot_under_test.h"

namespace prehend::drivers {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Command = msgs::GripperCommand;

// One robot of each kind for all tests; it takes some seconds to start.
std::map<std::string, std::unique_ptr<RobotUnderTest>>& robots() {
  static std::map<std::string, std::unique_ptr<RobotUnderTest>> all;
  return all;
}

class StopRobots : public ::testing::Environment {
  void TearDown() override { robots().clear(); }
};
const auto* const environment = ::testing::AddGlobalTestEnvironment(new StopRobots);

class Contract : public ::testing::TestWithParam<RobotKind> {
 protected:
  void SetUp() override {
    auto& robot = robots()[GetParam().name];
    const bool is_new = !robot;
    if (is_new) robot = std::make_unique<RobotUnderTest>(GetParam());
    robot_ = robot.get();
    const auto senses = [&] { return robot_->left.size() > 0 && robot_->wrenches.size() > 0; };
    ASSERT_TRUE(eventually(
        [&] {
          return robot_->states.size() > 0 && (senses() || !GetParam().has_senses()) &&
                 state().referenced();
        },
        40s))
        << robot_->output();
    if (is_new) {
      ASSERT_EQ(robot_->set_pace(), "");
    }
    RecordProperty("speed", std::to_string(robot_->speed()));
    // Each test begins with open, standing jaws.
    ASSERT_TRUE(eventually([&] { return move_to(0.06, 0.08)->reached(); })) << robot_->output();
    ASSERT_TRUE(eventually([&] { return stands(); }));
  }

  msgs::GripperState state() const { return robot_->states.last(); }
  msgs::MoveGripperGoal goal(double opening, double speed = 0.04) const {
    msgs::MoveGripperGoal message;
    message.set_opening(opening);
    message.set_speed(speed);
    message.set_stamp(robot_->node().clock().now());
    return message;
  }
  graph::Outcome<msgs::MoveGripperResult> move_to(double opening, double speed = 0.04) {
    return robot_->move.send(goal(opening, speed)).wait(60s);
  }
  /// Repeats a command for so long of the robot's time, as controllers do.
  void command_for(std::chrono::milliseconds time, Command::Mode mode, double value,
                   double current_limit = 0) {
    const std::int64_t end = robot_->node().clock().now() + std::chrono::nanoseconds(time).count();
    while (robot_->node().clock().now() < end) {
      robot_->command(mode, value, current_limit);
      std::this_thread::sleep_for(10ms);
    }
  }
  bool stands() const { return !state().moving() && std::abs(state().velocity()) < 1e-3; }

  bool has_begun_to_close() const { return state().moving() && state().opening() < 0.0595; }

  RobotUnderTest* robot_ = nullptr;
};

// Of robots that feel, too.
class ContractOfSenses : public Contract {};

template <class Message>
double rate_of(const std::vector<Message>& messages) {
  const double span = 1e-9 * static_cast<double>(messages.back().header().stamp() -
                                                 messages.front().header().stamp());
  return static_cast<double>(messages.size() - 1) / span;
}

template <class Message>
void expect_stamps_rise(const std::vector<Message>& messages) {
  for (std::size_t i = 1; i < messages.size(); ++i) {
    ASSERT_GE(messages[i].header().stamp(), messages[i - 1].header().stamp());
  }
  EXPECT_GT(messages.back().header().stamp(), messages.front().header().stamp());
}

TEST_P(Contract, GripperStateHasUnitsFrameAndRate) {
  robot_->states.clear();
  ASSERT_TRUE(eventually([&] { return robot_->states.size() >= 40; }));
  const auto states = robot_->states.all();
  expect_stamps_rise(states);
  EXPECT_GE(rate_of(states), 25);
  for (const auto& state : states) {
    EXPECT_EQ(state.header().frame_id(), "gripper");
    EXPECT_NEAR(state.opening(), 0.06, 5e-4);  // m
    EXPECT_EQ(state.error_code(), 0u);
    EXPECT_TRUE(state.referenced());
    EXPECT_FALSE(state.moving());
  }
}

TEST_P(ContractOfSenses, TactileFramesHaveShapePitchAndRate) {
  for (auto* log : {&robot_->left, &robot_->right}) {
    log->clear();
    ASSERT_TRUE(eventually([&] { return log->size() >= 15; }));
    const auto frames = log->all();
    expect_stamps_rise(frames);
    EXPECT_GE(rate_of(frames), 10);
    for (const auto& frame : frames) {
      EXPECT_EQ(frame.header().frame_id(), log == &robot_->left ? "left_pad" : "right_pad");
      EXPECT_EQ(frame.rows(), 14u);
      EXPECT_EQ(frame.columns(), 6u);
      EXPECT_NEAR(frame.texel_width(), 0.0034, 1e-6);  // m
      EXPECT_NEAR(frame.texel_height(), 0.0034, 1e-6);
      EXPECT_EQ(frame.full_scale(), 4095u);
      EXPECT_EQ(frame.intensity_size(), 84);
      EXPECT_GT(frame.newton_per_count(), 0);
      std::uint64_t counts = 0;
      for (const auto count : frame.intensity()) {
        EXPECT_LE(count, 4095u);
        counts += count;
      }
      // Counts are rounded, the simulated sum is not.
      EXPECT_NEAR(frame.sum(), static_cast<double>(counts) * frame.newton_per_count(),
                  84 * frame.newton_per_count() + 1e-9);
    }
  }
}

TEST_P(ContractOfSenses, WrenchIsTaredInTheGrippersFrame) {
  robot_->wrenches.clear();
  ASSERT_TRUE(eventually([&] { return robot_->wrenches.size() >= 40; }));
  const auto wrenches = robot_->wrenches.all();
  expect_stamps_rise(wrenches);
  EXPECT_GE(rate_of(wrenches), 30);
  for (const auto& wrench : wrenches) {
    EXPECT_EQ(wrench.header().frame_id(), "gripper");
    EXPECT_TRUE(wrench.biased());
    EXPECT_NEAR(wrench.wrench().force().z(), 0, 5);  // N; nothing touches it
    EXPECT_NEAR(wrench.wrench().torque().x(), 0, 1);
  }
}

TEST_P(Contract, MovesToOpeningsAndTellsHowFarItIs) {
  for (const double opening : {0.03, 0.055, 0.0685}) {
    std::atomic<int> feedbacks = 0;
    const auto handle =
        robot_->move.send(goal(opening, 0.08), [&](const msgs::MoveGripperFeedback& f) {
          feedbacks += f.opening() > 0 && f.opening() < 0.07;
        });
    const auto outcome = handle.wait(60s);
    ASSERT_TRUE(outcome) << outcome.error();
    EXPECT_TRUE(outcome->reached()) << outcome->reason();
    EXPECT_FALSE(outcome->blocked());
    EXPECT_NEAR(outcome->opening(), opening, 6e-4);
    EXPECT_GE(feedbacks, 1);
  }
}

TEST_P(Contract, RefusesGoalsThatMakeNoSenseInWords) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double before = state().opening();
  const struct {
    double opening, speed;
    const char* words;
  } goals[] = {{0.03, 0, "speed must be positive"},
               {0.03, -1, "speed must be positive"},
               {0.03, nan, "speed must be positive"},
               {0.5, 0.04, "0.069"},
               {-0.01, 0.04, "0.069"},
               {nan, 0.04, "finite"}};
  for (const auto& bad : goals) {
    const auto outcome = move_to(bad.opening, bad.speed);
    ASSERT_TRUE(outcome) << outcome.error();
    EXPECT_FALSE(outcome->reached());
    EXPECT_THAT(outcome->reason(), HasSubstr(bad.words)) << bad.opening << ' ' << bad.speed;
  }
  EXPECT_NEAR(state().opening(), before, 5e-4);
}

TEST_P(Contract, CancelledGoalStopsTheJaws) {
  const auto handle = robot_->move.send(goal(0.0, 0.01));
  ASSERT_TRUE(eventually([&] { return has_begun_to_close(); }));
  handle.cancel();
  const auto outcome = handle.wait(20s);
  EXPECT_EQ(outcome.status(), graph::Status::kCancelled);
  EXPECT_TRUE(eventually([&] { return stands(); }));
  EXPECT_GT(state().opening(), 0.01);
}

TEST_P(Contract, NewGoalPreemptsTheOneThatRuns) {
  const auto first = robot_->move.send(goal(0.0, 0.01));
  ASSERT_TRUE(eventually([&] { return has_begun_to_close(); }));
  const auto second = move_to(0.05);
  EXPECT_TRUE(second->reached()) << second->reason();
  EXPECT_EQ(first.wait(20s).status(), graph::Status::kPreempted);
}

TEST_P(Contract, CommandTakesTheGripperOverFromAGoal) {
  const auto message = goal(0.0, 0.01);
  const auto handle = robot_->move.send(message);
  ASSERT_TRUE(eventually([&] {
    return state().opening() < 0.0595 && robot_->node().clock().now() > message.stamp();
  }));
  robot_->command(Command::STOP, 0);
  const auto outcome = handle.wait(20s);
  ASSERT_TRUE(outcome) << outcome.error();
  EXPECT_EQ(outcome->reason(), "stopped by /gripper/command");
  EXPECT_TRUE(eventually([&] { return stands(); }));
  const auto later = goal(0.0, 0.01);
  const auto second = robot_->move.send(later);
  ASSERT_TRUE(
      eventually([&] { return state().moving() && robot_->node().clock().now() > later.stamp(); }));
  robot_->command(Command::VELOCITY, 0.005);
  EXPECT_EQ(second.wait(20s)->reason(), "another command took the gripper over");
  robot_->command(Command::STOP, 0);
  EXPECT_TRUE(eventually([&] { return stands(); }));
}

// Simulated time stands still then, and so do the jaws, but nothing blocks them.
TEST_P(Contract, WorldThatIsHeldUpIsNoBlockedGripper) {
  if (GetParam().world == RobotKind::World::kReal) return;
  const auto handle = robot_->move.send(goal(0.05, 0.01));
  ASSERT_TRUE(eventually([&] { return has_begun_to_close(); }));
  robot_->hold_world_up(1s);
  const auto outcome = handle.wait(60s);
  ASSERT_TRUE(outcome) << outcome.error();
  EXPECT_TRUE(outcome->reached()) << outcome->reason();
}

TEST_P(Contract, CommandStampedBeforeTheGoalIsIgnoredWhileItRuns) {
  const auto message = goal(0.05, 0.02);
  const auto handle = robot_->move.send(message);
  ASSERT_TRUE(eventually([&] { return has_begun_to_close(); }));
  robot_->command(Command::STOP, 0, 0, message.stamp());
  const auto outcome = handle.wait(60s);
  ASSERT_TRUE(outcome) << outcome.error();
  EXPECT_TRUE(outcome->reached()) << outcome->reason();
}

TEST_P(Contract, NegativeSpeedClosesAndTheWatchdogStopsIt) {
  robot_->states.clear();
  command_for(400ms, Command::VELOCITY, -0.01);
  const double opening = state().opening();
  EXPECT_LT(opening, 0.0585);
  EXPECT_TRUE(eventually([&] { return stands(); }, 10s));
  // 0.2 s of watchdog at 10 mm/s are 2 mm; unstopped, the jaws would close in 5 s. A machine under
  // load may be late.
  EXPECT_GT(state().opening(), opening - 0.03);
  double slowest = 0;
  for (const auto& one : robot_->states.all()) slowest = std::min(slowest, one.velocity());
  EXPECT_NEAR(slowest, -0.01, 3e-3);  // m/s, negative closes
}

TEST_P(Contract, SpeedIsCutToTheLimit) {
  robot_->states.clear();
  command_for(400ms, Command::VELOCITY, -10);
  robot_->command(Command::STOP, 0);
  EXPECT_TRUE(eventually([&] { return stands(); }));
  for (const auto& one : robot_->states.all()) EXPECT_LE(std::abs(one.velocity()), 0.085);
  EXPECT_EQ(state().error_code(), 0u);
}

TEST_P(Contract, PositionCommandGoesThere) {
  ASSERT_TRUE(eventually([&] {
    robot_->command(Command::POSITION, 0.04);
    std::this_thread::sleep_for(20ms);
    return std::abs(state().opening() - 0.04) < 6e-4 && stands();
  }));
}

TEST_P(Contract, BadCommandsAreRefusedAndNothingMoves) {
  const double before = state().opening();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  robot_->command(Command::POSITION, 0.5);
  robot_->command(Command::POSITION, nan);
  robot_->command(Command::VELOCITY, nan);
  robot_->command(Command::CURRENT, nan);
  robot_->command(Command::VOLTAGE, nan);
  robot_->command(static_cast<Command::Mode>(9), 0.01);
  std::this_thread::sleep_for(300ms);
  EXPECT_NEAR(state().opening(), before, 5e-4);
  EXPECT_TRUE(stands());
}

// The simulated motor does; the PG70's protocol has no such command, which is said.
TEST_P(Contract, VoltageMovesItOrIsRefusedByName) {
  const double before = state().opening();
  robot_->states.clear();
  command_for(400ms, Command::VOLTAGE, -2);
  if (!GetParam().takes_voltage()) {
    EXPECT_TRUE(eventually([&] {
      return robot_->output().find("VOLTAGE: the PG70 has no such command") != std::string::npos;
    })) << robot_->output();
    EXPECT_NEAR(state().opening(), before, 5e-4);
    EXPECT_TRUE(stands());
    EXPECT_EQ(state().error_code(), 0u);
    return;
  }
  const double opening = state().opening();
  EXPECT_LT(opening, before - 0.005);
  EXPECT_TRUE(eventually([&] { return stands(); }, 10s)) << "the watchdog stops it";
  EXPECT_GT(state().opening(), opening - 0.03);
  double slowest = 0;
  for (const auto& one : robot_->states.all()) slowest = std::min(slowest, one.velocity());
  EXPECT_NEAR(slowest, -0.037, 3e-3) << "m/s, of the back-EMF less friction";
}

// A block of 30 mm that nothing moves stands between the jaws.
class Block {
 public:
  explicit Block(RobotUnderTest& robot) : robot_(robot), joints_(robot.node(), "/joint_states") {
    if (robot.jaws()) {
      robot.jaws()->put_object(2 * kHalf);
      return;
    }
    EXPECT_TRUE(eventually([&] { return joints_.size() > 0; }));
    // The stage's slides go along the axes of the world, with its origin.
    const msgs::JointState stage = joints_.last();
    place({stage.position(0), stage.position(1), stage.position(2)});
  }
  ~Block() {
    if (robot_.jaws()) {
      robot_.jaws()->put_object(std::nullopt);
    } else {
      place({0, 0, -5});
    }
  }

 private:
  static constexpr double kHalf = 0.015;  // m

  void place(const Eigen::Vector3d& centre) {
    const graph::Outcome<msgs::SpawnResponse> outcome =
        robot_.node()
            .client<msgs::SpawnRequest, msgs::SpawnResponse>("/simulation/spawn")
            .call(request(centre), 10s);
    ASSERT_TRUE(outcome) << outcome.error();
    EXPECT_TRUE(outcome->success()) << outcome->reason();
  }
  static msgs::SpawnRequest request(const Eigen::Vector3d& centre) {
    geometry::TriangleMesh mesh;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d side(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      mesh.vertices.push_back(centre + kHalf * side);
    }
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    msgs::SpawnRequest message;
    message.set_name("block");
    *message.mutable_mesh() = convert::to_message(mesh);
    message.set_density(1000);
    message.set_is_static(true);
    return message;
  }

  RobotUnderTest& robot_;
  TopicLog<msgs::JointState> joints_;
};

TEST_P(Contract, GripsWhatStandsBetweenItsJaws) {
  if (GetParam().world == RobotKind::World::kReal) return;  // nothing can be put there by software
  const Block block(*robot_);
  const auto outcome = move_to(0.01);
  ASSERT_TRUE(outcome) << outcome.error();
  EXPECT_FALSE(outcome->reached());
  EXPECT_TRUE(outcome->blocked());
  EXPECT_EQ(outcome->reason(), "blocked");
  EXPECT_NEAR(outcome->opening(), 0.03, 0.007);  // the pads give way
  ASSERT_TRUE(eventually([&] { return move_to(0.06)->reached(); }));
  EXPECT_FALSE(state().blocked());
  const auto presses = [&](double current) {
    return eventually(
        [&] {
          robot_->command(Command::CURRENT, current);
          std::this_thread::sleep_for(10ms);
          return state().blocked() && std::abs(state().current() - current) < 0.1;
        },
        30s);
  };
  EXPECT_TRUE(presses(-0.8)) << state().ShortDebugString();
  EXPECT_TRUE(presses(-1.5)) << state().ShortDebugString();
  EXPECT_TRUE(!GetParam().has_senses() || eventually([&] {
    robot_->command(Command::CURRENT, -1.5);
    std::this_thread::sleep_for(10ms);
    return robot_->left.last().sum() > 5 && robot_->right.last().sum() > 5;  // N
  }));
  ASSERT_TRUE(eventually([&] { return move_to(0.06)->reached(); }));
}

TEST_P(Contract, JawsThatMeetNothingCloseWithoutBeingBlocked) {
  for (int i = 0; i < 300 && !(state().opening() < 0.004 && stands()); ++i) {
    robot_->command(Command::VELOCITY, -0.05, 1.0);
    std::this_thread::sleep_for(20ms);
  }
  EXPECT_LT(state().opening(), 0.004);
  EXPECT_FALSE(state().blocked());
  EXPECT_EQ(state().error_code(), 0u);
}

TEST_P(Contract, StopAndAcknowledge) {
  const auto handle = robot_->move.send(goal(0.0, 0.01));
  ASSERT_TRUE(eventually([&] { return has_begun_to_close(); }));
  EXPECT_TRUE(robot_->call("/gripper/stop").success());
  EXPECT_TRUE(eventually([&] { return stands(); }));
  const auto outcome = handle.wait(20s);
  ASSERT_TRUE(outcome) << outcome.error();
  EXPECT_EQ(outcome->reason(), "stopped by /gripper/stop");
  const auto acknowledged = robot_->call("/gripper/acknowledge");
  EXPECT_TRUE(acknowledged.success());
  EXPECT_EQ(acknowledged.reason(), "no error was present");
}

TEST_P(Contract, FastStopHoldsUntilItIsAcknowledged) {
  const auto handle = robot_->move.send(goal(0.0, 0.01));
  ASSERT_TRUE(eventually([&] { return has_begun_to_close(); }));
  EXPECT_TRUE(robot_->call("/gripper/fast_stop").success());
  EXPECT_TRUE(eventually([&] { return stands() && state().error_code() == 0xD9; }));
  EXPECT_FALSE(handle.wait(20s)->reached());
  const double opening = state().opening();
  EXPECT_THAT(move_to(0.03)->reason(), HasSubstr("acknowledge it first"));
  EXPECT_NEAR(state().opening(), opening, 1e-3);
  EXPECT_TRUE(robot_->call("/gripper/acknowledge").success());
  EXPECT_TRUE(eventually([&] { return state().error_code() == 0; }));
  EXPECT_TRUE(move_to(0.055, 0.08)->reached());
}

INSTANTIATE_TEST_SUITE_P(Robots, Contract, ::testing::ValuesIn(robot_kinds()),
                         [](const auto& kind) { return kind.param.name; });

std::vector<RobotKind> kinds_with_senses() {
  auto kinds = robot_kinds();
  std::erase_if(kinds, [](const RobotKind& kind) { return !kind.has_senses(); });
  return kinds;
}
INSTANTIATE_TEST_SUITE_P(Robots, ContractOfSenses, ::testing::ValuesIn(kinds_with_senses()),
                         [](const auto& kind) { return kind.param.name; });

}  // namespace
}  // namespace prehend::drivers
