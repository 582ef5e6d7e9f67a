// What stops the hand when the driver's process dies without a word, or lives but does nothing.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>
#include <string>

#include "drivers/barrett/driver/device.h"
#include "drivers/barrett/emulator/served_hand.h"
#include "drivers/barrett/node/hand_guard.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/guardian/guarded.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers::barrett {
namespace {

constexpr double kPatience = 0.5;  // s

class BarrettGuardian : public ::testing::Test {
 protected:
  void SetUp() override {
    // A name of its own: a guardian that lives on must not find another test's hand.
    auto end = std::make_unique<PseudoTerminal>(scratch_.path() / "hand");
    bus_ = "slcan:" + end->name();
    HandOptions options;
    options.plant = &plant_;
    options.is_awake = true;
    hand_ = std::make_unique<ServedHand>(
        options, std::make_unique<Slcan>(std::move(end), 0, std::vector<std::uint16_t>{}));
  }
  // A process with a driver, which moves the hand slowly and has a guardian.
  pid_t start_driver() {
    const pid_t process = ::fork();
    if (process != 0) return process;
    // Whatever becomes of the test, this process ends.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::alarm(60);
    const auto note = [](bool, const std::string&) {};
    Guarded guarded(guardian_program(bus_, 0), kPatience, note);
    DriverOptions options;
    options.initialisation = Initialisation::kDone;
    options.loss_time = 2;
    Device device(
        options, [this] { return open_hand_bus(bus_, 0); }, [](const Reading&) {}, note, 0.1,
        [&](const Reading& reading) -> std::string {
          return guarded.progress(watch_of(reading)) ? "it hung" : "";
        });
    while (device.reading().state < DriverState::kStanding) ::usleep(1000);
    HandGoal goal;
    goal.moves.fill(true);
    goal.position.fill(2);
    goal.speed.fill(0.05);
    std::uint64_t ticket = 0;
    device.with_driver(
        [&](HandDriver& driver, Time now) { return driver.move_to(goal, now, ticket); });
    while (true) ::usleep(1000);
  }
  static void end(pid_t driver) {
    ::kill(driver, SIGKILL);
    ::waitpid(driver, nullptr, 0);
  }
  bool moves() {
    return hand_->with_hand([](Hand& hand, Time) { return hand.is_moving(); });
  }
  bool begins() {
    return eventually([&] {
      return hand_->with_hand(
          [](Hand& hand, Time) { return hand.is_moving() && hand.motion().position[1] > 0.01; });
    });
  }
  std::uint64_t stops() {
    return hand_->with_hand([](Hand& hand, Time) { return hand.stops(); });
  }
  double way() {
    return hand_->with_hand([](Hand& hand, Time) { return hand.motion().position[1]; });
  }

  testing::ScratchFolder scratch_;
  std::string bus_;
  ClutchHand plant_;
  std::unique_ptr<ServedHand> hand_;
};

TEST_F(BarrettGuardian, StopsTheHandOfAProcessThatIsKilled) {
  const pid_t driver = start_driver();
  ASSERT_TRUE(begins());
  const auto before = stops();
  end(driver);
  ASSERT_TRUE(eventually([&] { return !moves(); }));
  EXPECT_GT(stops(), before);
  EXPECT_LT(way(), 1.9) << "stopped, not arrived";
}

TEST_F(BarrettGuardian, StopsTheHandOfAProcessThatHangs) {
  const pid_t driver = start_driver();
  ASSERT_TRUE(begins());
  ::kill(driver, SIGSTOP);
  ASSERT_TRUE(eventually([&] { return !moves(); }));
  EXPECT_LT(way(), 1.9) << "stopped, not arrived";
  // It comes back to a hand that stands, begins with a stop, and resumes nothing.
  const auto before = stops();
  const auto motions = hand_->with_hand([](Hand& hand, Time) { return hand.moves(); });
  ::kill(driver, SIGCONT);
  EXPECT_TRUE(eventually([&] { return stops() > before; }));
  EXPECT_EQ(hand_->with_hand([](Hand& hand, Time) { return hand.moves(); }), motions);
  EXPECT_FALSE(moves());
  end(driver);
}

// Pucks that do not take MODE are told CMD T.
TEST_F(BarrettGuardian, UnansweredStopBecomesMotorsOff) {
  const pid_t driver = start_driver();
  ASSERT_TRUE(begins());
  hand_->with_hand([](Hand& hand, Time) { hand.set_deaf_to(Property::kMode); });
  end(driver);
  EXPECT_TRUE(eventually([&] { return !moves(); }));
  EXPECT_LT(way(), 1.9);
}

TEST_F(BarrettGuardian, LeavesTheHandAloneAfterAGoodEnd) {
  {
    Guardian guardian(guardian_program(bus_, 0));
    guardian.progress(Watch::kMoving);
  }
  EXPECT_EQ(stops(), 0u);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);  // no process is left behind
}

TEST_F(BarrettGuardian, SaysWhenNothingAnswers) {
  const PseudoTerminal nobody;
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ::close(ends[1]);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(guard(ends[0], guarding("slcan:" + nobody.name(), 0), kPatience, 0.6), 1);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find(
                "barrett_guardian: the driver died and the hand CANNOT BE STOPPED"),
            std::string::npos);
  ::close(ends[0]);
}

}  // namespace
}  // namespace prehend::drivers::barrett
