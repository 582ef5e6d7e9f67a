// The emulated hand, as Barrett's software shows the real one.

#include <gtest/gtest.h>

#include "drivers/barrett/emulator/hand.h"

namespace prehend::drivers::barrett {
namespace {

class BarrettHand : public ::testing::Test {
 protected:
  void SetUp() override { make({}); }
  void make(HandOptions options) {
    options.plant = &plant_;
    hand_ = std::make_unique<Hand>(options, [this](const CanFrame& frame) {
      if (const auto reply = decode_reply(frame)) replies_.push_back(*reply);
    });
    run(0.001);
  }
  void run(double seconds) {
    for (const Time end = now_ + to_time(seconds); now_ < end;) {
      now_ += std::chrono::milliseconds(1);
      hand_->update(now_);
    }
  }
  void set(std::size_t axis, Property property, int value) {
    hand_->receive(encode(Request{axis, static_cast<std::uint8_t>(property), value}), now_);
  }
  std::optional<Reply> ask(std::size_t axis, Property property) {
    replies_.clear();
    hand_->receive(encode(Request{axis, static_cast<std::uint8_t>(property)}), now_);
    return replies_.empty() ? std::nullopt : std::optional(replies_.front());
  }
  int value(std::size_t axis, Property property) {
    const auto reply = ask(axis, property);
    return reply && std::holds_alternative<Value>(*reply) ? std::get<Value>(*reply).value : -9999;
  }
  void wake() {
    for (std::size_t i = 0; i < kAxes; ++i) set(i, Property::kStatus, 2);
    run(0.3);
  }
  void command(std::size_t axis, Command command) {
    set(axis, Property::kCommand, static_cast<int>(command));
  }

  Time now_ = std::chrono::seconds(5);
  ClutchHand plant_;
  std::unique_ptr<Hand> hand_;
  std::vector<Reply> replies_;
};

TEST_F(BarrettHand, SleepsInMonitorModeUntilItIsWoken) {
  EXPECT_EQ(value(0, Property::kStatus), 0);
  EXPECT_FALSE(ask(0, Property::kPosition));
  command(0, Command::kClose);
  run(1);
  EXPECT_EQ(hand_->motion().position[0], 0);
  wake();
  EXPECT_EQ(value(0, Property::kStatus), 2);
  EXPECT_TRUE(ask(0, Property::kPosition));
  EXPECT_EQ(value(0, Property::kVersion), 174);
}

TEST_F(BarrettHand, InitialisesAtTheOpenStopWhichBecomesZero) {
  plant_.place(0, 0.7);
  make({});
  wake();
  EXPECT_EQ(std::get<Position>(*ask(0, Property::kPosition)).motor, 0) << "zero is where it stood";
  command(0, Command::kInitialise);
  EXPECT_NE(value(0, Property::kMode), 0);
  run(2);
  EXPECT_EQ(value(0, Property::kMode), 0);
  EXPECT_NEAR(hand_->motion().position[0], 0, 1e-6);
  EXPECT_EQ(std::get<Position>(*ask(0, Property::kPosition)).motor, 0);
}

TEST_F(BarrettHand, MovesToItsTargetAndEndsIdleOrHolding) {
  wake();
  for (const std::size_t axis : {std::size_t{0}, kSpread}) {
    set(axis, Property::kDefaultPosition, 20000);
    set(axis, Property::kStallTime, 250);
    command(axis, Command::kMove);
    EXPECT_EQ(value(axis, Property::kMode), 5);
    run(3);
    EXPECT_EQ(value(axis, Property::kMode), axis == kSpread ? 3 : 0);
    EXPECT_NEAR(std::get<Position>(*ask(axis, Property::kPosition)).motor, 20000, 400);
  }
  // As setting M does.
  set(0, Property::kMove, 40000);
  run(3);
  EXPECT_NEAR(std::get<Position>(*ask(0, Property::kPosition)).motor, 40000, 400);
}

TEST_F(BarrettHand, KeepsItsSpeedAndStallsAfterTstop) {
  wake();
  set(0, Property::kMostVelocity, 40);
  set(0, Property::kStallTime, 250);
  plant_.put_object(0, 0.5);
  command(0, Command::kClose);
  double fastest = 0;
  for (int i = 0; i < 900; ++i) {
    run(0.001);
    fastest = std::max(fastest, hand_->motion().velocity[0]);
  }
  const Gearing gearing;
  EXPECT_NEAR(fastest, 40e3 / gearing.counts_per_radian(0), 1e-3);
  EXPECT_EQ(value(0, Property::kMode), 5);
  run(0.5);
  EXPECT_EQ(value(0, Property::kMode), 0);
  EXPECT_NEAR(hand_->motion().position[0], 0.5, 1e-6);
}

TEST_F(BarrettHand, TellsBothEncodersWhereTheClutchIsOpen) {
  wake();
  plant_.hold_joint(0, 0.4, 0.9);
  set(0, Property::kStallTime, 100);
  command(0, Command::kClose);
  run(3);
  const Position position = std::get<Position>(*ask(0, Property::kPosition));
  const Gearing gearing;
  ASSERT_TRUE(position.joint);
  EXPECT_NEAR(position.motor / gearing.counts_per_radian(0), 0.9, 1e-3);
  EXPECT_NEAR(*position.joint / gearing.joint_counts_per_radian(), 0.4, 1e-3);
  EXPECT_FALSE(std::get<Position>(*ask(kSpread, Property::kPosition)).joint);
}

TEST_F(BarrettHand, TorqueFallsNearOtemp) {
  wake();
  set(0, Property::kMostTorque, 1000);
  set(0, Property::kStallTime, 0);
  plant_.put_object(0, 0.1);
  command(0, Command::kClose);
  run(1);
  EXPECT_NEAR(hand_->motion().current[0], 1000, 1);
  hand_->set_temperature(52);  // half way from 44 to 60
  run(0.1);
  EXPECT_NEAR(hand_->motion().current[0], 500, 30);
  hand_->set_temperature(61);
  run(0.1);
  EXPECT_EQ(hand_->motion().current[0], 0);
}

TEST_F(BarrettHand, ImagesComeWithTactAndInOrder) {
  Cells cells{};
  cells[0] = 256;
  cells[23] = 4095;
  hand_->set_cells(2, cells);
  wake();
  replies_.clear();
  set(2, Property::kTactile, 2);
  ASSERT_EQ(replies_.size(), kTactileFrames);
  TactileAssembler pad;
  std::optional<Cells> image;
  for (const Reply& reply : replies_) image = pad.add(std::get<TactilePart>(reply));
  EXPECT_EQ(image, cells);
  ask(2, Property::kTactile);  // a question while all are on
  EXPECT_EQ(replies_.size(), kTactileFrames);
  EXPECT_EQ(value(2, Property::kTactileId), 4);
  hand_->set_pad_failure(true);
  EXPECT_EQ(value(2, Property::kTactileId), -2);
}

TEST_F(BarrettHand, ModeZeroAndCommandTStop) {
  wake();
  for (const bool by_command : {false, true}) {
    set(0, Property::kMove, by_command ? 0 : 190000);
    run(0.2);
    EXPECT_TRUE(hand_->is_moving());
    if (by_command) {
      command(0, Command::kOff);
    } else {
      set(0, Property::kMode, 0);
    }
    const double there = hand_->motion().position[0];
    run(0.5);
    EXPECT_FALSE(hand_->is_moving());
    EXPECT_NEAR(hand_->motion().position[0], there, 0.01);
  }
}

TEST(BarrettEmulator, NeedsAPlant) { EXPECT_THROW(Hand({}, {}), std::invalid_argument); }

}  // namespace
}  // namespace prehend::drivers::barrett
