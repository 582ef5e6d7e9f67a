// The BH8-262's driver and an emulated hand on real lines: a serial one with its rate, pulled and
// plugged, and TCP.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/barrett/driver/gcl/device.h"
#include "drivers/barrett/driver/gcl/probe.h"
#include "drivers/barrett/emulator/gcl/hand.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "drivers/wire/stream/tcp_server.h"
#include "prehend/geometry/errors.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers::barrett::gcl {
namespace {

using ::testing::HasSubstr;

class GclOnALine : public ::testing::Test {
 protected:
  HandOptions of_hand(const PseudoTerminal* terminal) {
    HandOptions all;
    all.plant = &plant_;
    all.is_initialised = true;
    all.boot_time = 0.05;
    if (terminal != nullptr) all.host_baud = [terminal] { return terminal->baud(); };
    return all;
  }
  static DriverOptions of_driver(unsigned fast_baud = 0) {
    DriverOptions all;
    all.fast_baud = fast_baud;
    all.loss_time = 3;  // a loaded machine may be held up
    all.block_time = all.reply_time = 1;
    all.stall_time = 1;
    return all;
  }
  static HandGoal goal(double position, double speed) {
    HandGoal goal;
    goal.moves.fill(true);
    goal.position.fill(position);
    goal.speed.fill(speed);
    return goal;
  }
  std::string move(Device& device, double position, double speed) {
    return device.with_driver([&](HandDriver& driver, Time now) {
      return driver.move_to(goal(position, speed), now, ticket_);
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
  static bool moves(ServedDevice<Hand>& hand) {
    return hand.with_device([](Hand& h, Time) { return h.is_moving(); });
  }
  bool begins(ServedDevice<Hand>& hand) {
    return eventually([&] { return moves(hand); });
  }

  ClutchHand plant_;
  Notes notes_;
  std::uint64_t ticket_ = 0;
};

TEST_F(GclOnALine, AgreesOnARateMovesAndStopsAtTheEnd) {
  for (const unsigned fast : {0u, 38400u}) {
    auto end = std::make_unique<PseudoTerminal>();
    PseudoTerminal* const terminal = end.get();
    const std::string line = end->name();
    plant_ = {};
    ServedDevice<Hand> hand(of_hand(terminal), std::move(end));
    {
      Device device(
          of_driver(fast), [&] { return open_byte_stream(line, kBaud); }, [](const Reading&) {},
          notes_.taker(), 0.05);
      ASSERT_TRUE(stands(device));
      EXPECT_EQ(terminal->baud(), fast == 0 ? kBaud : fast);
      ASSERT_EQ(move(device, 0.5, 1), "");
      EXPECT_TRUE(reaches(device));
      ASSERT_EQ(move(device, 0.1, 0.05), "");
      ASSERT_TRUE(begins(hand));
    }
    EXPECT_FALSE(moves(hand)) << "it is told to stop at the end";
    EXPECT_FALSE(hand.with_device([](Hand& h, Time) { return h.is_looping(); }));
  }
}

TEST_F(GclOnALine, OverTcpThereIsNoRate) {
  auto end = std::make_unique<TcpServer>();
  const std::string line = end->name();
  ServedDevice<Hand> hand(of_hand(nullptr), std::move(end));
  Device device(
      of_driver(), [&] { return open_byte_stream(line, kBaud); }, [](const Reading&) {},
      notes_.taker(), 0.05);
  ASSERT_TRUE(stands(device));
  ASSERT_EQ(move(device, 0.5, 1), "");
  EXPECT_TRUE(reaches(device));
}

TEST_F(GclOnALine, PulledPlugIsReportedAndNothingResumes) {
  const testing::ScratchFolder scratch;
  const std::string link = scratch.path() / "hand";
  auto end = std::make_unique<PseudoTerminal>(link);
  PseudoTerminal* const terminal = end.get();
  ServedDevice<Hand> hand(of_hand(terminal), std::move(end));
  Device device(
      of_driver(), [&] { return open_byte_stream(link, kBaud); }, [](const Reading&) {},
      notes_.taker(), 0.05);
  ASSERT_TRUE(stands(device));
  ASSERT_EQ(move(device, 2, 0.05), "");
  ASSERT_TRUE(begins(hand));
  terminal->unplug();
  EXPECT_TRUE(eventually([&] { return device.reading().state == DriverState::kDisconnected; }));
  EXPECT_TRUE(notes_.has("the motion goes on until it stalls"));
  EXPECT_EQ(move(device, 1, 1), "the hand is not connected");
  terminal->plug();
  EXPECT_TRUE(stands(device));
  EXPECT_FALSE(moves(hand));
  ASSERT_EQ(move(device, 0.3, 1), "");
  EXPECT_TRUE(reaches(device));
}

TEST_F(GclOnALine, MissingLineIsToldWithItsMend) {
  Device device(
      {}, [] { return open_byte_stream("/dev/no_hand", kBaud); }, [](const Reading&) {},
      notes_.taker(), 0.05);
  EXPECT_TRUE(eventually([&] { return !device.line_problem().empty(); }));
  EXPECT_TRUE(notes_.has("/dev/no_hand"));
}

TEST_F(GclOnALine, ProbeFindsTheRateAndMovesNothing) {
  for (const unsigned baud : {9600u, 38400u}) {
    auto end = std::make_unique<PseudoTerminal>();
    const std::string line = end->name();
    HandOptions options = of_hand(end.get());
    options.baud = baud;
    options.is_initialised = false;
    options.boot_time = 0;
    ServedDevice<Hand> hand(options, std::move(end));
    const Probe found = probe(line, std::chrono::seconds(4));
    EXPECT_EQ(found.result, Probe::Result::kAnswers) << found.what;
    EXPECT_THAT(found.what, HasSubstr("answers at " + std::to_string(baud) + " baud"));
    EXPECT_THAT(found.what, HasSubstr("4.31, 25 degree Celsius; not initialised"));
    EXPECT_EQ(hand.with_device([](Hand& h, Time) { return h.moves() + h.aborts(); }), 0u);
  }
}

TEST(GclProbe, SilenceIsReportedWithItsMend) {
  const PseudoTerminal nobody;
  const Probe answer = probe(nobody.name(), std::chrono::milliseconds(40));
  EXPECT_EQ(answer.result, Probe::Result::kSilent);
  EXPECT_THAT(answer.what, HasSubstr("the hand does not answer on " + nobody.name()));
  EXPECT_THAT(answer.mend, HasSubstr("24 V"));
  EXPECT_THROW(probe("/dev/no_hand"), geometry::InputError);
}

}  // namespace
}  // namespace prehend::drivers::barrett::gcl
