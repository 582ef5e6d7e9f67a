// The emulated controller is as strict as the real one.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "drivers/kuka_rsi/emulator/controller.h"

namespace prehend::drivers::kuka_rsi {
namespace {

using ::testing::HasSubstr;

class RsiController : public ::testing::Test {
 protected:
  static ControllerOptions options() {
    ControllerOptions o;
    o.lower.fill(-3);
    o.upper.fill(3);
    o.speed.fill(4);
    return o;
  }
  // A cycle that is answered with the correction of A1, `delay` after the telegram.
  void cycle(Controller& controller, double a1, Time delay = std::chrono::milliseconds(1),
             std::string_view type = "ImFree", std::int64_t stamp_off = 0,
             std::string_view message = "") {
    now_ += std::chrono::milliseconds(12);
    const std::string_view text = controller.tick(now_);
    const char* why = "";
    if (read_robot_telegram(text, {}, telegram_, why) != TelegramResult::kGood) return;
    TelegramNames names;
    names.type = type;
    std::array<char, 512> out;
    const auto stamp = telegram_.ipoc.value + static_cast<std::uint64_t>(stamp_off);
    const std::size_t size = write_sensor_telegram(out, names, Axes{a1}, Ipoc::of(stamp), message);
    controller.receive({out.data(), size}, now_ + delay);
  }
  SimpleArm arm_{Axes{}};
  RobotTelegram telegram_;
  Time now_{std::chrono::seconds(5)};
};

TEST_F(RsiController, CountsWhatIsLateWrongOrOldAndHoldsTheLast) {
  Controller controller(arm_, options());
  controller.begin();
  cycle(controller, 1);
  cycle(controller, 1);
  EXPECT_EQ(controller.delay(), 0u);
  cycle(controller, 2, std::chrono::milliseconds(11));      // 10 ms are given
  cycle(controller, 2, std::chrono::milliseconds(1), "X");  // Delay shows the one before
  EXPECT_EQ(telegram_.delay, 1u);
  cycle(controller, 2, std::chrono::milliseconds(1), "ImFree", -12);
  EXPECT_EQ(telegram_.delay, 2u);
  cycle(controller, 1);
  EXPECT_EQ(telegram_.delay, 3u);
  EXPECT_NEAR(controller.set_point()[0], 1 * std::numbers::pi / 180, 1e-9);
  cycle(controller, 1);
  EXPECT_EQ(telegram_.delay, 3u);
}

TEST_F(RsiController, WithoutHoldOnALostAnswerIsAStepBack) {
  ControllerOptions o = options();
  o.holds = false;
  Controller controller(arm_, o);
  controller.begin();
  cycle(controller, 2);
  cycle(controller, 2, std::chrono::seconds(1));
  EXPECT_GT(controller.set_point()[0], 0.03);
  cycle(controller, 2);
  EXPECT_EQ(controller.set_point()[0], 0);
}

TEST_F(RsiController, EndsRsiByEitherWayOfCounting) {
  for (const bool total : {false, true}) {
    ControllerOptions o = options();
    o.counts_total = total;
    Controller controller(arm_, o);
    controller.begin();
    for (int i = 0; i < 9; ++i) cycle(controller, 0, std::chrono::seconds(1));
    cycle(controller, 0);
    cycle(controller, 0, std::chrono::seconds(1));
    cycle(controller, 0);
    EXPECT_EQ(controller.state(),
              total ? Controller::State::kStopped : Controller::State::kRunning);
  }
}

TEST_F(RsiController, EndsRsiWhereCorrectionsAreTooMuch) {
  const struct {
    double first, second;  // deg of A1, in two cycles
    std::string message, why;
  } ends[] = {{1, 91, "", "overall correction exceeded at A1"},
              {1, 20, "", "axis speed exceeded at A1"},
              {1, std::nan(""), "", ""},
              {1, 1, "Error: tactile limit", "EStr: Error: tactile limit"},
              {1, 1, "all is well", ""}};
  for (const auto& one : ends) {
    Controller controller(arm_, options());
    controller.begin();
    cycle(controller, one.first);
    cycle(controller, one.second, std::chrono::milliseconds(1), "ImFree", 0, one.message);
    cycle(controller, one.second);
    EXPECT_EQ(controller.why(), one.why) << one.second;
  }
  ControllerOptions o = options();
  o.upper.fill(0.01);
  Controller controller(arm_, o);
  controller.begin();
  cycle(controller, 1);
  cycle(controller, 1);
  EXPECT_EQ(controller.why(), "software limit switch of A1");
}

TEST_F(RsiController, ClampsSilentlyWhereItHasAnObjectForIt) {
  ControllerOptions o = options();
  o.clamp = 1;
  Controller controller(arm_, o);
  controller.begin();
  cycle(controller, 5);
  cycle(controller, 5);
  EXPECT_EQ(controller.state(), Controller::State::kRunning);
  EXPECT_NEAR(controller.set_point()[0], 1 * std::numbers::pi / 180, 1e-9);
}

TEST_F(RsiController, BeginsAnewWhereTheArmStandsAndItsTimeGoesOn) {
  Controller controller(arm_, options());
  controller.begin();
  for (int i = 0; i < 30; ++i) cycle(controller, 2);
  const std::uint64_t stamp = telegram_.ipoc.value;
  controller.end("emergency stop");
  cycle(controller, 2);
  controller.begin();
  cycle(controller, 0, std::chrono::seconds(1));
  EXPECT_GT(telegram_.ipoc.value, stamp);
  EXPECT_EQ(telegram_.delay, 0u);
  EXPECT_NEAR((*telegram_.commanded_axes)[0], 2, 0.01);
}

}  // namespace
}  // namespace prehend::drivers::kuka_rsi
