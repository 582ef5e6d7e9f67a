// Driver and emulated hand on real buses: an adapter's serial line, pulled and plugged; bus-off.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "drivers/barrett/driver/device.h"
#include "drivers/barrett/driver/probe.h"
#include "drivers/barrett/emulator/served_hand.h"
#include "drivers/wire/can/in_process_can.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "prehend/geometry/errors.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers::barrett {
namespace {

using ::testing::HasSubstr;

HandGoal far_goal(double speed) {
  HandGoal goal;
  goal.moves.fill(true);
  goal.position.fill(0.8);
  goal.speed.fill(speed);
  return goal;
}

class BarrettOnABus : public ::testing::Test {
 protected:
  HandOptions of_hand() {
    HandOptions all;
    all.plant = &plant_;
    all.is_awake = true;
    return all;
  }
  static DriverOptions of_driver() {
    DriverOptions all;
    all.initialisation = Initialisation::kDone;
    all.loss_time = 2;  // a loaded machine may be held up
    return all;
  }
  /// The adapter's line, served.
  std::unique_ptr<CanBus> adapter(std::unique_ptr<PseudoTerminal> terminal) {
    return std::make_unique<Slcan>(std::move(terminal), 0, std::vector<std::uint16_t>{});
  }
  std::string move(Device& device, double speed = 1) {
    return device.with_driver([&](HandDriver& driver, Time now) {
      return driver.move_to(far_goal(speed), now, ticket_);
    });
  }
  bool reaches(Device& device) {
    return eventually([&] {
      return device.with_driver([&](HandDriver& driver, Time) {
        return driver.report(ticket_).kind == MotionReport::Kind::kReached;
      });
    });
  }
  bool stands(Device& device) {
    return eventually([&] { return device.reading().state == DriverState::kStanding; });
  }

  ClutchHand plant_;
  Notes notes_;
  std::uint64_t ticket_ = 0;
};

TEST_F(BarrettOnABus, MovesOverAnAdapterAndStopsAtTheEnd) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const std::string line = "slcan:" + terminal->name();
  ServedHand hand(of_hand(), adapter(std::move(terminal)));
  {
    Device device(
        of_driver(), [&] { return open_hand_bus(line, 0); }, [](const Reading&) {}, notes_.taker(),
        0.05);
    ASSERT_TRUE(stands(device));
    ASSERT_EQ(move(device), "");
    EXPECT_TRUE(reaches(device));
    HandGoal back = far_goal(0.05);
    back.position.fill(0.1);
    device.with_driver([&](HandDriver& driver, Time now) { driver.move_to(back, now, ticket_); });
    ASSERT_TRUE(
        eventually([&] { return hand.with_hand([](Hand& h, Time) { return h.is_moving(); }); }));
  }
  EXPECT_FALSE(hand.with_hand([](Hand& h, Time) { return h.is_moving(); }));
}

TEST_F(BarrettOnABus, PulledPlugIsReportedAndNothingResumes) {
  const testing::ScratchFolder scratch;
  const std::string link = scratch.path() / "hand";
  auto end = std::make_unique<PseudoTerminal>(link);
  PseudoTerminal* const terminal = end.get();
  ServedHand hand(of_hand(), adapter(std::move(end)));
  Device device(
      of_driver(), [&] { return open_hand_bus("slcan:" + link, 0); }, [](const Reading&) {},
      notes_.taker(), 0.05);
  ASSERT_TRUE(stands(device));
  ASSERT_EQ(move(device, 0.02), "");
  ASSERT_TRUE(
      eventually([&] { return hand.with_hand([](Hand& h, Time) { return h.is_moving(); }); }));
  ASSERT_TRUE(eventually([&] { return device.reading().state == DriverState::kMoving; }));
  const auto moves = hand.with_hand([](Hand& h, Time) { return h.moves(); });
  terminal->unplug();
  EXPECT_TRUE(eventually([&] { return device.reading().state == DriverState::kDisconnected; }));
  EXPECT_TRUE(notes_.has("the motion goes on to its target"));
  EXPECT_EQ(move(device), "the hand is not connected");
  terminal->plug();
  EXPECT_TRUE(stands(device));
  EXPECT_FALSE(hand.with_hand([](Hand& h, Time) { return h.is_moving(); }));
  EXPECT_EQ(hand.with_hand([](Hand& h, Time) { return h.moves(); }), moves);
  ASSERT_EQ(move(device), "");
  EXPECT_TRUE(reaches(device));
}

TEST_F(BarrettOnABus, BusOffIsReportedAndEndsTheMotion) {
  const auto bus = InProcessCan::create();
  ServedHand hand(of_hand(), bus->join());
  Device device(
      of_driver(), [&] { return bus->join(); }, [](const Reading&) {}, notes_.taker(), 0.05);
  ASSERT_TRUE(stands(device));
  ASSERT_EQ(move(device, 0.02), "");
  ASSERT_TRUE(eventually([&] { return device.reading().state == DriverState::kMoving; }));
  bus->set_bus_off(true);
  EXPECT_TRUE(eventually([&] { return device.reading().state == DriverState::kDisconnected; }));
  EXPECT_TRUE(eventually([&] { return !device.line_problem().empty(); }));
  bus->set_bus_off(false);
  EXPECT_TRUE(stands(device));
  EXPECT_FALSE(hand.with_hand([](Hand& h, Time) { return h.is_moving(); }));
  EXPECT_EQ(device.line_problem(), "");
}

TEST_F(BarrettOnABus, MissingBusIsToldWithItsMend) {
  Device device(
      {}, [] { return open_hand_bus("slcan:/dev/no_adapter", 0); }, [](const Reading&) {},
      notes_.taker(), 0.05);
  EXPECT_TRUE(eventually([&] { return !device.line_problem().empty(); }));
  EXPECT_TRUE(notes_.has("/dev/no_adapter"));
}

TEST_F(BarrettOnABus, ProbeSaysWhoItIsAndMovesNothing) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const std::string line = "slcan:" + terminal->name();
  HandOptions options = of_hand();
  options.is_awake = false;
  ServedHand hand(options, adapter(std::move(terminal)));
  const Probe asleep = probe(line, 0, std::chrono::seconds(5));
  EXPECT_EQ(asleep.result, Probe::Result::kAnswers) << asleep.what;
  EXPECT_THAT(asleep.what, HasSubstr("answers: four pucks, firmware 174"));
  EXPECT_THAT(asleep.what, HasSubstr("F1 is in monitor mode"));
  hand.with_hand([](Hand& h, Time) {
    EXPECT_EQ(h.moves() + h.stops(), 0u);
    h.set_error(true);
  });
  const Probe unfit = probe(line, 0, std::chrono::seconds(5));
  EXPECT_EQ(unfit.result, Probe::Result::kWarns);
  EXPECT_THAT(unfit.what, HasSubstr("F1 shows STAT 1"));
  hand.with_hand([](Hand& h, Time) { h.set_mute(true, 2); });
  const Probe partial = probe(line, 0, std::chrono::milliseconds(200));
  EXPECT_EQ(partial.result, Probe::Result::kSilent);
  EXPECT_THAT(partial.what, HasSubstr("not F3 (node 13)"));
}

TEST(BarrettProbe, SilenceIsReportedWithItsMend) {
  const PseudoTerminal nobody;
  const Probe answer = probe("slcan:" + nobody.name(), 0, std::chrono::milliseconds(50));
  EXPECT_EQ(answer.result, Probe::Result::kSilent);
  EXPECT_THAT(answer.what, HasSubstr("the hand does not answer on slcan:" + nobody.name()));
  EXPECT_THAT(answer.mend, HasSubstr("48 V"));
  EXPECT_THROW(probe("slcan:/dev/no_adapter"), geometry::InputError);
}

TEST_F(BarrettOnABus, HandThatSomebodyTalksToIsNotAsked) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const std::string line = "slcan:" + terminal->name();
  // A line on which a hand answers somebody.
  Slcan other(std::move(terminal), 0, {});
  std::atomic<bool> ends = false;
  std::thread talks([&] {
    while (!ends) {
      other.send(encode(Position{0, 100}));
      other.receive(std::chrono::milliseconds(5));
    }
  });
  const Probe answer = probe(line, 0, std::chrono::seconds(1));
  ends = true;
  talks.join();
  EXPECT_EQ(answer.result, Probe::Result::kWarns);
  EXPECT_THAT(answer.what, HasSubstr("so it was not asked"));
}

}  // namespace
}  // namespace prehend::drivers::barrett
