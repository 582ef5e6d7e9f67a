// What stops the gripper when the driver's process dies without a word, or lives but does nothing.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>

#include "drivers/pg70/driver/device.h"
#include "drivers/pg70/emulator/served_module.h"
#include "drivers/pg70/node/gripper_guard.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/guardian/guarded.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers::pg70 {
namespace {

class Pg70Guardian : public ::testing::Test {
 protected:
  Pg70Guardian() {
    auto terminal = std::make_unique<PseudoTerminal>(
        std::filesystem::temp_directory_path() / ("prehend_guard_" + std::to_string(::getpid())));
    address_.line = "slcan:" + terminal->name();
    module_ = std::make_unique<ServedModule>(
        plant_, ModuleOptions{},
        make_can_link(std::make_unique<Slcan>(std::move(terminal), 0, std::vector<std::uint16_t>{}),
                      address_.module, Side::kModule));
  }
  // A process with a driver, which moves the gripper slowly and has a guardian. Its notes come by
  // the pipe notes_.
  pid_t start_driver() {
    EXPECT_EQ(::pipe2(notes_, O_NONBLOCK | O_CLOEXEC), 0);
    const pid_t process = ::fork();
    if (process != 0) return process;
    // Whatever becomes of the test, this process ends.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::alarm(60);
    const auto note = [this](bool, const std::string& words) {
      const std::string line = words + "\n";
      if (::write(notes_[1], line.data(), line.size()) < 0) ::_exit(1);
    };
    Guarded guarded(guardian_program(address_), kPatience, note);
    std::atomic<Device*> itself = nullptr;
    Device device(
        {}, [this] { return open_link(address_); }, [](const Reading&) {}, note, 0.1,
        [&](const Reading& reading) {
          if (guarded.progress(watch_of(reading)) && itself) itself.load()->begin_anew("it hung");
        });
    itself = &device;
    while (device.reading().state != DriverState::kStanding) ::usleep(1000);
    std::uint64_t ticket = 0;
    device.with_driver(
        [&](Driver& driver, Time now) { return driver.move_to(0.0, 0.005, 0, now, ticket); });
    while (true) ::usleep(1000);
  }
  ~Pg70Guardian() override {
    for (const int end : notes_) {
      if (end >= 0) ::close(end);
    }
  }
  static void end(pid_t driver) {
    ::kill(driver, SIGKILL);
    ::waitpid(driver, nullptr, 0);
  }
  bool noted(const std::string& part) {
    return eventually([&] {
      char text[1024];
      const ssize_t count = ::read(notes_[0], text, sizeof text);
      if (count > 0) heard_.append(text, static_cast<std::size_t>(count));
      return heard_.find(part) != std::string::npos;
    });
  }
  static pid_t guardian_of(pid_t driver) {
    const auto found = testing::descendants(driver, "pg70_guardian");
    return found.empty() ? -1 : found.front();
  }
  bool moves() {
    return module_->with_module([](Module& module, Time) { return module.is_moving(); });
  }
  std::uint64_t stops() {
    return module_->with_module([](Module& module, Time) { return module.stops(); });
  }

  static constexpr double kPatience = 0.5;  // s
  LinkAddress address_;
  int notes_[2] = {-1, -1};
  std::string heard_;
  SimpleGripper plant_;
  std::unique_ptr<ServedModule> module_;
};

TEST_F(Pg70Guardian, StopsTheGripperOfAProcessThatIsKilled) {
  const pid_t driver = start_driver();
  ASSERT_GT(driver, 0);
  ASSERT_TRUE(eventually([&] { return moves(); }));
  const auto before = stops();
  ::kill(driver, SIGKILL);
  ::waitpid(driver, nullptr, 0);
  const Time killed = steady_now();
  ASSERT_TRUE(eventually([&] { return !moves(); }, std::chrono::seconds(10)));
  RecordProperty("seconds_from_kill_to_stop", std::to_string(to_seconds(steady_now() - killed)));
  EXPECT_GT(stops(), before);
  const double opening = module_->with_module([](Module& m, Time) { return m.motion().opening; });
  EXPECT_GT(opening, 0.01);  // m: stopped, not arrived
}

// It went on moving, and nobody noticed.
TEST_F(Pg70Guardian, StopsTheGripperOfAProcessThatHangs) {
  const pid_t driver = start_driver();
  ASSERT_GT(driver, 0);
  ASSERT_TRUE(eventually([&] { return moves(); }));
  ::kill(driver, SIGSTOP);
  const Time stopped = steady_now();
  ASSERT_TRUE(eventually([&] { return !moves(); }, std::chrono::seconds(10)));
  RecordProperty("seconds_from_hang_to_stop", std::to_string(to_seconds(steady_now() - stopped)));
  const double opening = module_->with_module([](Module& m, Time) { return m.motion().opening; });
  EXPECT_GT(opening, 0.01);  // m: stopped, not arrived
  // It comes back to a gripper that stands, begins with a stop, and resumes nothing.
  const auto stops_before = stops();
  const auto motions = module_->with_module([](Module& m, Time) { return m.motions(); });
  ::kill(driver, SIGCONT);
  EXPECT_TRUE(noted("it hung"));
  EXPECT_TRUE(eventually([&] { return stops() > stops_before; }));
  EXPECT_EQ(module_->with_module([](Module& m, Time) { return m.motions(); }), motions);
  EXPECT_FALSE(moves());
  end(driver);
}

TEST_F(Pg70Guardian, OneThatDiedIsReplaced) {
  const pid_t driver = start_driver();
  ASSERT_TRUE(eventually([&] { return moves(); }));
  const pid_t first = guardian_of(driver);
  ASSERT_GT(first, 0);
  const auto before = stops();
  ::kill(first, SIGKILL);
  ASSERT_TRUE(noted("the guardian of the gripper died; another one was started"));
  const pid_t second = guardian_of(driver);
  ASSERT_GT(second, 0);
  EXPECT_NE(second, first);
  EXPECT_EQ(stops(), before);  // the gripper is left alone
  end(driver);
  ASSERT_TRUE(eventually([&] { return stops() > before && !moves(); }));  // by the second one
}

TEST_F(Pg70Guardian, OneThatHangsIsReplaced) {
  const pid_t driver = start_driver();
  ASSERT_TRUE(eventually([&] { return moves(); }));
  const pid_t first = guardian_of(driver);
  ASSERT_GT(first, 0);
  ::kill(first, SIGSTOP);
  ASSERT_TRUE(noted("the guardian of the gripper did not react any more; another one was started"));
  ASSERT_TRUE(eventually([&] { return guardian_of(driver) > 0 && guardian_of(driver) != first; }));
  end(driver);
  ASSERT_TRUE(eventually([&] { return !moves(); }));
}

// The wire that swallows CMD STOP gets CMD FAST STOP.
TEST_F(Pg70Guardian, UnansweredStopBecomesAFastStop) {
  module_->with_module([](Module& m, Time now) {
    m.set_deaf_to(Command::kStop);
    m.receive(encode(Move{.command = Command::kMovePosition, .count = 2, .values = {0, 5}}), now);
  });
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ::close(ends[1]);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(guard(ends[0], guarding(address_), kPatience, 20), 0);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("CMD FAST STOP was sent and answered"),
            std::string::npos);
  EXPECT_FALSE(moves());
  ::close(ends[0]);
}

TEST_F(Pg70Guardian, LeavesTheGripperAloneAfterAGoodEnd) {
  {
    Guardian guardian(guardian_program(address_));
    guardian.progress(Watch::kMoving);
  }
  EXPECT_EQ(stops(), 0u);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);  // no process is left behind
}

TEST_F(Pg70Guardian, SaysWhenNothingAnswers) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ::close(ends[1]);
  LinkAddress other = address_;
  other.module = 13;
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(guard(ends[0], guarding(other), kPatience, 0.2), 1);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("CANNOT BE STOPPED"), std::string::npos);
  ::close(ends[0]);
}

}  // namespace
}  // namespace prehend::drivers::pg70
