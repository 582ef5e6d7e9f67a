// What stops the hand when the driver's process dies without a word, or lives but does nothing.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>
#include <string>

#include "drivers/sdh/driver/device.h"
#include "drivers/sdh/emulator/hand.h"
#include "drivers/sdh/node/hand_guard.h"
#include "drivers/wire/guardian/guarded.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "drivers/wire/stream/tcp_server.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers::sdh {
namespace {

constexpr unsigned kLineRate = 115200;
constexpr double kPatience = 0.5;  // s

class SdhGuardian : public ::testing::Test {
 protected:
  void serve(bool is_tcp) {
    std::unique_ptr<ByteStream> end;
    if (is_tcp) {
      end = std::make_unique<TcpServer>();
    } else {
      // A name of its own: a guardian that lives on must not find another test's hand.
      end = std::make_unique<PseudoTerminal>(scratch_.path() / "hand");
    }
    line_ = end->name();
    HandOptions options;
    options.plant = &plant_;
    options.has_checksum = !is_tcp;
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
    Guarded guarded(guardian_program(line_, kLineRate), kPatience, note);
    DriverOptions options;
    options.has_checksum = !line_.starts_with("tcp");
    Device device(
        options, [this] { return open_byte_stream(line_, kLineRate); }, [](const Reading&) {}, note,
        0.1,
        [&](const Reading& reading) -> std::string {
          return guarded.progress(watch_of(reading)) ? "it hung" : "";
        });
    while (device.reading().state < DriverState::kOff) ::usleep(1000);
    HandGoal goal;
    goal.moves.fill(true);
    goal.position.fill(1.2);
    goal.speed.fill(0.05);
    std::uint64_t ticket = 0;
    device.with_driver([&](Driver& driver, Time now) { return driver.move_to(goal, now, ticket); });
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
  std::uint64_t stops() {
    return hand_->with_device([](Hand& hand, Time) { return hand.stops(); });
  }
  double way() {
    return hand_->with_device([](Hand& hand, Time) { return hand.motion().position[1]; });
  }

  testing::ScratchFolder scratch_;
  std::string line_;
  SimpleHand plant_;
  std::unique_ptr<ServedDevice<Hand>> hand_;
};

TEST_F(SdhGuardian, StopsTheHandOfAProcessThatIsKilled) {
  for (const bool is_tcp : {false, true}) {
    plant_ = {};
    serve(is_tcp);
    const pid_t driver = start_driver();
    ASSERT_TRUE(begins()) << line_;
    const auto before = stops();
    end(driver);
    const Time killed = steady_now();
    ASSERT_TRUE(eventually([&] { return !moves(); })) << line_;
    RecordProperty(is_tcp ? "tcp_seconds_from_kill_to_stop" : "seconds_from_kill_to_stop",
                   std::to_string(to_seconds(steady_now() - killed)));
    EXPECT_GT(stops(), before);
    EXPECT_LT(way(), 1.1) << "stopped, not arrived";
    hand_.reset();
  }
}

TEST_F(SdhGuardian, StopsTheHandOfAProcessThatHangs) {
  serve(false);
  const pid_t driver = start_driver();
  ASSERT_TRUE(begins());
  ::kill(driver, SIGSTOP);
  ASSERT_TRUE(eventually([&] { return !moves(); }));
  EXPECT_LT(way(), 1.1) << "stopped, not arrived";
  // It comes back to a hand that stands, begins with a stop, and resumes nothing.
  const auto before = stops();
  const auto motions = hand_->with_device([](Hand& hand, Time) { return hand.moves(); });
  ::kill(driver, SIGCONT);
  EXPECT_TRUE(eventually([&] { return stops() > before; }));
  EXPECT_EQ(hand_->with_device([](Hand& hand, Time) { return hand.moves(); }), motions);
  EXPECT_FALSE(moves());
  end(driver);
}

// A hand that does not take `stop` is switched off.
TEST_F(SdhGuardian, UnansweredStopBecomesPowerOff) {
  serve(false);
  const pid_t driver = start_driver();
  ASSERT_TRUE(begins());
  hand_->with_device([](Hand& hand, Time) { hand.set_deaf_to(Command::kStop); });
  end(driver);
  EXPECT_TRUE(eventually(
      [&] { return hand_->with_device([](Hand& hand, Time) { return !hand.is_powered(1); }); }));
}

TEST_F(SdhGuardian, LeavesTheHandAloneAfterAGoodEnd) {
  serve(false);
  {
    Guardian guardian(guardian_program(line_, kLineRate));
    guardian.progress(Watch::kMoving);
  }
  EXPECT_EQ(stops(), 0u);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);  // no process is left behind
}

TEST_F(SdhGuardian, SaysWhenNothingAnswers) {
  const PseudoTerminal nobody;
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ::close(ends[1]);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(guard(ends[0], guarding(nobody.name(), kLineRate), kPatience, 0.6), 1);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find(
                "sdh_guardian: the driver died and the hand CANNOT BE STOPPED"),
            std::string::npos);
  ::close(ends[0]);
}

}  // namespace
}  // namespace prehend::drivers::sdh
