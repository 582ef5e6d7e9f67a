// What stops the gripper when the driver's process dies without a word.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "drivers/pg70/driver/device.h"
#include "drivers/pg70/emulator/served_module.h"
#include "drivers/pg70/node/guardian.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "tests/drivers/eventually.h"

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
  // A process with a driver, which moves the gripper slowly and has a guardian.
  pid_t start_driver() {
    const pid_t process = ::fork();
    if (process != 0) return process;
    const Guardian guardian(address_);
    Device device(
        {}, [this] { return open_link(address_); }, [](const Reading&) {},
        [](bool, const std::string&) {});
    while (device.reading().state != DriverState::kStanding) ::usleep(1000);
    std::uint64_t ticket = 0;
    device.with_driver(
        [&](Driver& driver, Time now) { return driver.move_to(0.0, 0.005, 0, now, ticket); });
    while (true) ::usleep(1000);
  }
  bool moves() {
    return module_->with_module([](Module& module, Time) { return module.is_moving(); });
  }
  std::uint64_t stops() {
    return module_->with_module([](Module& module, Time) { return module.stops(); });
  }

  LinkAddress address_;
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

TEST_F(Pg70Guardian, LeavesTheGripperAloneAfterAGoodEnd) {
  { const Guardian guardian(address_); }
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
  EXPECT_EQ(guard(ends[0], other, 0.2), 1);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("CANNOT BE STOPPED"), std::string::npos);
  ::close(ends[0]);
}

}  // namespace
}  // namespace prehend::drivers::pg70
