// What stops a BH8-262 when its driver's process dies without a word, or lives but does nothing: it
// has no watchdog, and in RealTime mode its last velocities go on.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>
#include <string>

#include "drivers/barrett/driver/gcl/device.h"
#include "drivers/barrett/emulator/gcl/hand.h"
#include "drivers/barrett/node/hand_guard.h"
#include "drivers/wire/guardian/guarded.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr double kPatience = 0.5;  // s

class GclGuardian : public ::testing::TestWithParam<unsigned> {
 protected:
  void SetUp() override {
    // A name of its own: a guardian that lives on must not find another test's hand.
    auto end = std::make_unique<PseudoTerminal>(scratch_.path() / "hand");
    line_ = end->name();
    HandOptions options;
    options.plant = &plant_;
    options.is_initialised = true;
    options.boot_time = 0.05;
    options.host_baud = [terminal = end.get()] { return terminal->baud(); };
    hand_ = std::make_unique<ServedDevice<Hand>>(options, std::move(end));
  }
  // A process with a driver, which moves the hand slowly and has a guardian.
  pid_t start_driver() {
    const pid_t process = ::fork();
    if (process != 0) return process;
    // Whatever becomes of the test, this process ends.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::alarm(60);
    const auto note = [](bool, const std::string&) {};
    Guarded guarded(guardian_program(line_, kBaud, GetParam()), kPatience, note);
    DriverOptions options;
    options.fast_baud = GetParam();
    options.loss_time = options.block_time = options.reply_time = 2;
    Device device(
        options, [this] { return open_byte_stream(line_, kBaud); }, [](const Reading&) {}, note,
        0.1,
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
    return hand_->with_device([](Hand& hand, Time) { return hand.is_moving(); });
  }
  bool begins() {
    return eventually([&] {
      return hand_->with_device(
          [](Hand& hand, Time) { return hand.is_moving() && hand.motion().position[1] > 0.01; });
    });
  }
  std::uint64_t aborts() {
    return hand_->with_device([](Hand& hand, Time) { return hand.aborts(); });
  }
  double way() {
    return hand_->with_device([](Hand& hand, Time) { return hand.motion().position[1]; });
  }

  testing::ScratchFolder scratch_;
  std::string line_;
  ClutchHand plant_;
  std::unique_ptr<ServedDevice<Hand>> hand_;
};

TEST_P(GclGuardian, StopsTheHandOfAProcessThatIsKilled) {
  const pid_t driver = start_driver();
  ASSERT_TRUE(begins());
  const auto before = aborts();
  end(driver);
  ASSERT_TRUE(eventually([&] { return !moves(); }));
  EXPECT_GT(aborts(), before);
  EXPECT_LT(way(), 1.9) << "stopped, not arrived";
}

TEST_P(GclGuardian, StopsTheHandOfAProcessThatHangs) {
  const pid_t driver = start_driver();
  ASSERT_TRUE(begins());
  ::kill(driver, SIGSTOP);
  ASSERT_TRUE(eventually([&] { return !moves(); }));
  EXPECT_LT(way(), 1.9) << "stopped, not arrived";
  // It comes back to a hand that stands, begins with Ctrl-C, and resumes nothing.
  const auto before = aborts();
  const auto motions = hand_->with_device([](Hand& hand, Time) { return hand.moves(); });
  ::kill(driver, SIGCONT);
  EXPECT_TRUE(eventually([&] { return aborts() > before; }));
  EXPECT_EQ(hand_->with_device([](Hand& hand, Time) { return hand.moves(); }), motions);
  EXPECT_FALSE(moves());
  end(driver);
}

TEST_P(GclGuardian, LeavesTheHandAloneAfterAGoodEnd) {
  {
    Guardian guardian(guardian_program(line_, kBaud, GetParam()));
    guardian.progress(Watch::kMoving);
  }
  EXPECT_EQ(aborts(), 0u);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);  // no process is left behind
}

INSTANTIATE_TEST_SUITE_P(Rates, GclGuardian, ::testing::Values(0u, 38400u),
                         [](const auto& rate) { return "Fast" + std::to_string(rate.param); });

TEST(GclGuardianAlone, SaysWhenNothingAnswers) {
  const PseudoTerminal nobody;
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ::close(ends[1]);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(guard(ends[0], guarding(nobody.name(), kBaud, 38400), kPatience, 0.6), 1);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find(
                "barrett_guardian: the driver died and the hand CANNOT BE STOPPED"),
            std::string::npos);
  ::close(ends[0]);
}

}  // namespace
}  // namespace prehend::drivers::barrett::gcl
