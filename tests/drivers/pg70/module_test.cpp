// The emulated module by itself: it has to be as strict and as quirky as the manual says.

#include "drivers/pg70/emulator/module.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace prehend::drivers::pg70 {
namespace {

class Pg70Module : public ::testing::Test {
 protected:
  std::vector<Response> ask(const Request& request) { return ask(encode(request)); }
  std::vector<Response> ask(const Content& content) {
    said_.clear();
    module_.receive(content, now_);
    return said_;
  }
  std::vector<Response> run(double seconds) {
    said_.clear();
    const Time end = now_ + to_time(seconds);
    while (now_ < end) {
      now_ += std::chrono::milliseconds(2);
      module_.update(now_);
    }
    return said_;
  }
  static Content content(std::initializer_list<std::uint8_t> bytes) {
    return Content(std::vector<std::uint8_t>(bytes));
  }
  static Move move(Command command, std::initializer_list<float> values) {
    Move result{.command = command, .count = static_cast<std::uint8_t>(values.size())};
    std::copy(values.begin(), values.end(), result.values.begin());
    return result;
  }
  void expect_refusal(const Request& request, InfoCode reason) {
    const auto said = ask(request);
    ASSERT_EQ(said.size(), 1u);
    const auto* refusal = std::get_if<Refusal>(&said[0]);
    ASSERT_TRUE(refusal);
    EXPECT_EQ(refusal->reason, reason);
    EXPECT_EQ(module_.motions(), 0u);
  }
  int count_of(const std::vector<Response>& said, const Response& wanted) const {
    return static_cast<int>(std::count(said.begin(), said.end(), wanted));
  }

  Time now_ = std::chrono::seconds(5);
  std::vector<Response> said_;
  std::vector<Direction> directions_;
  SimpleGripper plant_;
  ModuleOptions options_;
  Module module_{plant_, options_, [this](Direction direction, const Content& said) {
                   directions_.push_back(direction);
                   said_.push_back(decode_response(said, kWithAll));
                 }};
};

TEST_F(Pg70Module, RefusesUnknownCommandsAndWrongLengths) {
  EXPECT_EQ(
      ask(content({0xFE})),
      (std::vector<Response>{Refusal{static_cast<Command>(0xFE), InfoCode::kUnknownCommand}}));
  // GET STATE with a period but no mode, as one public client sends it.
  EXPECT_EQ(ask(content({0x95, 0, 0, 0x80, 0x3F})),
            (std::vector<Response>{Refusal{Command::kGetState, InfoCode::kMessageLength}}));
  EXPECT_EQ(ask(content({0xB0, 1, 2})),
            (std::vector<Response>{Refusal{Command::kMovePosition, InfoCode::kMessageLength}}));
  EXPECT_EQ(ask(content({0x91, 0})),
            (std::vector<Response>{Refusal{Command::kStop, InfoCode::kMessageLength}}));
}

TEST_F(Pg70Module, RefusesValuesOutOfRange) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  expect_refusal(move(Command::kMovePosition, {70}), InfoCode::kValueAboveMaximum);
  expect_refusal(move(Command::kMovePosition, {-1}), InfoCode::kValueBelowMinimum);
  expect_refusal(move(Command::kMovePosition, {nan}), InfoCode::kWrongParameter);
  expect_refusal(move(Command::kMovePosition, {10, 0}), InfoCode::kWrongParameter);
  expect_refusal(move(Command::kMovePosition, {10, 84}), InfoCode::kValueAboveMaximum);
  expect_refusal(move(Command::kMovePosition, {10, 80, 400}), InfoCode::kValueAboveMaximum);
  expect_refusal(move(Command::kMovePosition, {10, 80, 300, 7}), InfoCode::kValueAboveMaximum);
  expect_refusal(move(Command::kMovePositionRelative, {1}), InfoCode::kValueAboveMaximum);
  expect_refusal(move(Command::kMoveVelocity, {-90}), InfoCode::kValueAboveMaximum);
  expect_refusal(move(Command::kMoveCurrent, {-7}), InfoCode::kValueAboveMaximum);
  expect_refusal(SetTarget{Command::kSetTargetVelocity, 0}, InfoCode::kWrongParameter);
  expect_refusal(SetTarget{Command::kSetTargetCurrent, 9}, InfoCode::kValueAboveMaximum);
  expect_refusal(GetState{GetState::Cycle{-1, kWithAll}}, InfoCode::kWrongParameter);
  expect_refusal(GetState{GetState::Cycle{nan, kWithAll}}, InfoCode::kWrongParameter);
  expect_refusal(GetState{GetState::Cycle{1, 8}}, InfoCode::kWrongParameter);
  expect_refusal(GetConfig{0x99}, InfoCode::kWrongParameter);
  expect_refusal(SetConfig{1, {2}}, InfoCode::kNoRights);
  expect_refusal(PlainRequest{Command::kGetDetailedError}, InfoCode::kFailed);  // no error
}

TEST_F(Pg70Module, TellsItsConfiguration) {
  EXPECT_EQ(ask(GetConfig{0x06}), (std::vector<Response>{ConfigValue{0x06, {0}}}));
  const auto value = [&](ConfigParameter parameter) {
    const auto said = ask(GetConfig{static_cast<std::uint8_t>(parameter)});
    return load_little<float>(std::get<ConfigValue>(said.at(0)).value.data());
  };
  EXPECT_NEAR(value(ConfigParameter::kSoftHigh), 69, 1e-4);  // mm
  EXPECT_NEAR(value(ConfigParameter::kMaximumVelocity), 83, 1e-4);
  EXPECT_NEAR(value(ConfigParameter::kMaximumCurrent), 6.5, 1e-6);
  const auto facts = ask(GetConfig{});
  ASSERT_TRUE(std::holds_alternative<DeviceFacts>(facts.at(0)));
  EXPECT_EQ(encode(facts[0]).size(), 45u);
}

TEST_F(Pg70Module, CyclicStatesKeepTheirPeriodUntilStopped) {
  ask(GetState{GetState::Cycle{0.04F, kWithPosition | kWithCurrent}});
  const auto said = run(2);
  EXPECT_NEAR(static_cast<double>(said.size()), 50, 1);
  const auto once = ask(GetState{});  // with the mode last given; ends the cycle
  EXPECT_EQ(once.size(), 1u);
  EXPECT_EQ(encode(once[0]).size(), 11u);  // two floats
  EXPECT_TRUE(run(1).empty());
}

TEST_F(Pg70Module, MoveAnswersItsDurationAndEndsWithAnImpulse) {
  const auto said = ask(move(Command::kMovePosition, {29, 80, 320}));
  ASSERT_TRUE(std::holds_alternative<MoveStarted>(said.at(0)));
  const double duration = std::get<MoveStarted>(said[0]).duration;
  EXPECT_NEAR(duration, 0.04 / 0.08 + 0.08 / 0.32, 1e-3);  // trapezoid over 40 mm
  EXPECT_TRUE(run(duration - 0.1).empty());
  const auto end = run(0.3);
  ASSERT_EQ(end.size(), 1u);
  EXPECT_EQ(std::get<MotionEnd>(end[0]).kind, Command::kPositionReached);
  EXPECT_NEAR(std::get<MotionEnd>(end[0]).position, 29, 0.1);
}

TEST_F(Pg70Module, ImpulseMessagesCanBeSwitchedOff) {
  EXPECT_EQ(ask(PlainRequest{Command::kToggleImpulse}),
            (std::vector<Response>{ImpulseMessages{false}}));
  ask(move(Command::kMovePosition, {50, 80, 320}));
  EXPECT_TRUE(run(2).empty());
  EXPECT_EQ(ask(PlainRequest{Command::kToggleImpulse}),
            (std::vector<Response>{ImpulseMessages{true}}));
}

TEST_F(Pg70Module, ErrorsAreRepeatedEvery15SecondsAndWarningsEvery30) {
  module_.fail(ErrorCode::kMotorVoltageLow, true, now_);
  const Response error = Fault{Command::kError, ErrorCode::kMotorVoltageLow};
  const Response warning = Fault{Command::kWarning, ErrorCode::kMotorVoltageLow};
  EXPECT_EQ(directions_.back(), Direction::kError);
  EXPECT_EQ(count_of(run(61), error), 4);
  expect_refusal(move(Command::kMovePosition, {10}), InfoCode::kFailed);
  const auto acknowledged = ask(PlainRequest{Command::kAcknowledge});
  EXPECT_EQ(acknowledged, (std::vector<Response>{Confirmation{Command::kAcknowledge}, warning}));
  EXPECT_EQ(count_of(run(61), warning), 2);
  said_.clear();
  module_.mend(now_);
  EXPECT_EQ(said_, (std::vector<Response>{Info{8}}));
  EXPECT_TRUE(run(61).empty());
}

TEST_F(Pg70Module, FastStopHasNoOkAndIsClearedByAcknowledgeOnly) {
  EXPECT_EQ(ask(PlainRequest{Command::kFastStop}),
            (std::vector<Response>{Fault{Command::kError, ErrorCode::kFastStop}}));
  expect_refusal(move(Command::kMovePosition, {10}), InfoCode::kFailed);
  EXPECT_EQ(ask(PlainRequest{Command::kAcknowledge}),
            (std::vector<Response>{Confirmation{Command::kAcknowledge}, Info{8}}));
  EXPECT_EQ(ask(move(Command::kMovePosition, {60})).size(), 1u);
  EXPECT_EQ(module_.motions(), 1u);
}

TEST_F(Pg70Module, TargetsHoldForMotionsThatNameNone) {
  ask(SetTarget{Command::kSetTargetVelocity, 20});
  ask(SetTarget{Command::kSetTargetAcceleration, 320});
  ask(move(Command::kMovePosition, {0}));
  run(0.5);
  EXPECT_NEAR(module_.motion().velocity, -0.02, 1e-4);
  ask(move(Command::kMovePosition, {0, 40}));
  run(0.5);
  EXPECT_NEAR(module_.motion().velocity, -0.04, 1e-4);
  ask(move(Command::kMovePosition, {69}));  // 40 mm/s stay in force
  run(0.4);
  EXPECT_NEAR(module_.motion().velocity, 0.04, 1e-4);
}

TEST_F(Pg70Module, RebootIsSilentAndForgets) {
  ask(GetState{GetState::Cycle{0.02F, kWithAll}});
  EXPECT_EQ(ask(PlainRequest{Command::kReboot}),
            (std::vector<Response>{Confirmation{Command::kReboot}}));
  EXPECT_TRUE(ask(GetState{}).empty());
  EXPECT_TRUE(run(0.9).empty());
  EXPECT_EQ(run(1), (std::vector<Response>{Info{1}}));  // INFO BOOT, and no cyclic states
  EXPECT_EQ(encode(ask(GetState{}).at(0)).size(), 3u);  // mode 0 at power-on
}

TEST_F(Pg70Module, ReferencingEndsReferenced) {
  ModuleOptions fresh;
  fresh.referenced = false;
  std::vector<Response> said;
  Module module(plant_, fresh, [&](Direction, const Content& content) {
    said.push_back(decode_response(content, kWithAll));
  });
  module.receive(encode(move(Command::kMovePosition, {10})), now_);
  EXPECT_EQ(said,
            (std::vector<Response>{Refusal{Command::kMovePosition, InfoCode::kNotReferenced}}));
  said.clear();
  module.receive(encode(PlainRequest{Command::kReference}), now_);
  EXPECT_EQ(said, (std::vector<Response>{Confirmation{Command::kReference}}));
  for (int i = 0; i < 3000; ++i) module.update(now_ += std::chrono::milliseconds(2));
  EXPECT_EQ(std::get<MotionEnd>(said.back()).kind, Command::kMoveBlocked);
  EXPECT_NEAR(module.motion().opening, 0, 1e-3);
}

}  // namespace
}  // namespace prehend::drivers::pg70
