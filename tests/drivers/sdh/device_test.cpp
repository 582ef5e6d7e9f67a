// Driver and emulated hand on real lines: pseudo-terminals and TCP, pulled and plugged.

#include <gtest/gtest.h>

#include "drivers/sdh/driver/device.h"
#include "drivers/sdh/emulator/hand.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "drivers/wire/stream/tcp_server.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers::sdh {
namespace {

HandGoal far_goal(double speed) {
  HandGoal goal;
  goal.moves.fill(true);
  goal.position.fill(0.8);
  goal.speed.fill(speed);
  return goal;
}

class SdhOnALine : public ::testing::Test {
 protected:
  HandOptions options(bool is_tcp) {
    HandOptions all;
    all.plant = &plant_;
    all.has_checksum = !is_tcp;
    return all;
  }
  static Device::Open open(const std::string& line) {
    return [line] { return open_byte_stream(line, 115200); };
  }
  std::string move(Device& device, double speed = 1) {
    return device.with_driver(
        [&](Driver& driver, Time now) { return driver.move_to(far_goal(speed), now, ticket_); });
  }
  bool reaches(Device& device) {
    return eventually([&] {
      return device.with_driver([&](Driver& driver, Time) {
        return driver.report(ticket_).kind == MotionReport::Kind::kReached;
      });
    });
  }

  SimpleHand plant_;
  Notes notes_;
  std::uint64_t ticket_ = 0;
};

TEST_F(SdhOnALine, MovesOverSerialAndTcpAndIsSwitchedOffAtTheEnd) {
  for (const bool is_tcp : {false, true}) {
    std::unique_ptr<ByteStream> end;
    if (is_tcp) {
      end = std::make_unique<TcpServer>();
    } else {
      end = std::make_unique<PseudoTerminal>();
    }
    const std::string line = end->name();
    plant_ = {};
    ServedDevice<Hand> hand(options(is_tcp), std::move(end));
    DriverOptions of_driver;
    of_driver.has_checksum = !is_tcp;
    {
      Device device(
          of_driver, open(line), [](const Reading&) {}, notes_.taker(), 0.05);
      ASSERT_TRUE(eventually([&] { return device.reading().state >= DriverState::kOff; })) << line;
      ASSERT_EQ(move(device), "");
      EXPECT_TRUE(reaches(device));
    }
    EXPECT_FALSE(hand.with_device([](Hand& h, Time) { return h.is_powered(0); }));
  }
}

TEST_F(SdhOnALine, PulledPlugIsReportedAndNothingResumes) {
  const testing::ScratchFolder scratch;
  const std::string link = scratch.path() / "hand";
  auto end = std::make_unique<PseudoTerminal>(link);
  PseudoTerminal* const terminal = end.get();
  ServedDevice<Hand> hand(options(false), std::move(end));
  Device device(
      {}, open(link), [](const Reading&) {}, notes_.taker(), 0.05);
  ASSERT_TRUE(eventually([&] { return device.reading().state >= DriverState::kOff; }));
  ASSERT_EQ(move(device, 0.02), "");
  ASSERT_TRUE(
      eventually([&] { return hand.with_device([](Hand& h, Time) { return h.is_moving(); }); }));
  ASSERT_TRUE(eventually([&] { return device.reading().state == DriverState::kMoving; }));
  terminal->unplug();
  EXPECT_TRUE(eventually([&] { return device.reading().state == DriverState::kDisconnected; }));
  EXPECT_TRUE(notes_.has("the motion goes on to its target"));
  EXPECT_EQ(move(device), "the hand is not connected");
  terminal->plug();
  EXPECT_TRUE(eventually([&] { return device.reading().state == DriverState::kStanding; }));
  EXPECT_FALSE(hand.with_device([](Hand& h, Time) { return h.is_moving(); }));
  EXPECT_EQ(hand.with_device([](Hand& h, Time) { return h.moves(); }), 1u);
  ASSERT_EQ(move(device), "");
  EXPECT_TRUE(reaches(device));
}

TEST_F(SdhOnALine, MissingLineIsToldWithItsMend) {
  Device device(
      {}, open("/dev/no_hand"), [](const Reading&) {}, notes_.taker(), 0.05);
  EXPECT_TRUE(eventually([&] { return !device.line_problem().empty(); }));
  EXPECT_TRUE(notes_.has("/dev/no_hand"));
}

}  // namespace
}  // namespace prehend::drivers::sdh
