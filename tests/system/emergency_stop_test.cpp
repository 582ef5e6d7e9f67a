// Emulated robots that are stopped on their way, as processes: arm and hand stand in the world,
// refuse to move by name, and move again after a reset. How long it takes: bench_emergency_stop.

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"
#include "tests/system/stop_rig.h"

namespace prehend::testing {
namespace {

using namespace std::chrono_literals;
using drivers::eventually;
using std::chrono::steady_clock;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class EmergencyStopped : public ::testing::TestWithParam<StoppedRobot> {
 protected:
  void SetUp() override {
    rig_ = std::make_unique<StopRig>(GetParam());
    ASSERT_THAT(rig_->wait_until_ready(), IsEmpty());
  }
  void expect_all_stands(StopRig::Time from) {
    EXPECT_TRUE(rig_->wait_until_stands(from, 20s)) << rig_->output();
    // It does not begin anew by itself.
    std::this_thread::sleep_for(500ms);
    EXPECT_TRUE(rig_->wait_until_stands(from, 5s)) << rig_->output();
  }
  // Who hears of the reset late is not ready yet, or tells only then of the silence before it,
  // which is a stop of his own: then it is reset again, as a person would.
  void expect_moves_after_reset() {
    constexpr int kTries = 5;
    std::string problem;
    for (int i = 0; i < kTries; ++i) {
      const msgs::Acknowledge answer = rig_->reset();
      EXPECT_TRUE(answer.success()) << answer.reason();
      std::this_thread::sleep_for(600ms);
      if (rig_->is_stopped()) {
        problem = "stopped anew: " + rig_->reason();
        continue;
      }
      problem = rig_->move();
      if (problem.empty()) return;
    }
    ADD_FAILURE() << problem << '\n' << rig_->output();
  }
  Outcome command(const std::vector<std::string>& arguments) const {
    std::vector<std::string> words{"stop"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    words.insert(words.end(), {"--registry", rig_->registry()});
    return run_program("prehend", words, 20s);
  }

  std::unique_ptr<StopRig> rig_;
};

TEST_P(EmergencyStopped, OnItsWayUntilItIsReset) {
  ASSERT_THAT(rig_->move(), IsEmpty());
  const auto from = steady_clock::now();
  const Outcome stopped = command({"--reason", "a hand in the cell"});
  EXPECT_EQ(stopped.exit_code, 0) << stopped.output;
  EXPECT_THAT(rig_->reasons(),
              Each(HasSubstr("emergency stop by prehend stop: a hand in the cell")));
  expect_all_stands(from);
  EXPECT_THAT(rig_->refusals(), Each(HasSubstr("emergency stop by prehend stop")));
  expect_all_stands(from);
  const Outcome reset = command({"--reset"});
  EXPECT_EQ(reset.exit_code, 0) << reset.output;
  expect_moves_after_reset();
}

TEST_P(EmergencyStopped, WhenTheNodeThatStopsDies) {
  ASSERT_THAT(rig_->move(), IsEmpty());
  const auto from = steady_clock::now();
  ASSERT_TRUE(rig_->kill("emergency_stop"));
  EXPECT_THAT(rig_->reasons(), Each(HasSubstr("the node emergency_stop was not heard")));
  expect_all_stands(from);
  EXPECT_THAT(rig_->refusals(), Each(HasSubstr("was not heard")));
  const Outcome nobody = command({});
  EXPECT_NE(nobody.exit_code, 0);
  EXPECT_THAT(nobody.output, AllOf(HasSubstr("NOT STOPPED"), HasSubstr("/arm/stop")));
  // Whoever takes its place is told that all is stopped.
  rig_->start_emergency_stop();
  ASSERT_TRUE(eventually([&] { return rig_->is_stopped(); }));
  EXPECT_THAT(rig_->reason(), HasSubstr("was not heard"));
  expect_moves_after_reset();
}

TEST_P(EmergencyStopped, WhenARequiredDriverIsKilled) {
  const std::string killed = GetParam().required.back();
  ASSERT_THAT(rig_->move(), IsEmpty());
  const auto from = steady_clock::now();
  ASSERT_TRUE(rig_->kill(killed));
  EXPECT_THAT(rig_->reasons(),
              Each(HasSubstr("required node " + killed + " was lost: its process ended")));
  expect_all_stands(from);
  // It is started again; until then its name is what the reset says.
  EXPECT_TRUE(eventually([&] { return rig_->reset().success(); }));
  expect_moves_after_reset();
}

TEST_P(EmergencyStopped, WhenADeviceStopsByItself) {
  const DeviceFault& fault = GetParam().fault;
  const auto set = [&](const std::string& value) {
    const Outcome done = run_program(
        "prehend",
        {"param", "set", fault.emulator, fault.parameter, value, "--registry", rig_->registry()},
        20s);
    EXPECT_EQ(done.exit_code, 0) << done.output;
  };
  ASSERT_THAT(rig_->move(), IsEmpty());
  const auto from = steady_clock::now();
  set(fault.value);
  // What is not the device's own: a device that nobody hears does as it likes.
  EXPECT_THAT(rig_->reasons().at(fault.other), HasSubstr("emergency stop by " + fault.words));
  EXPECT_TRUE(eventually([&] {
    const StopRig::Track track = fault.other == 0 ? rig_->arm_since(from) : rig_->hand_since(from);
    return track.stood && *track.stands < steady_clock::now() - 500ms;
  })) << rig_->output();
  if (!fault.mended.empty()) {
    const msgs::Acknowledge refused = rig_->reset();
    EXPECT_FALSE(refused.success());
    EXPECT_THAT(refused.reason(), AllOf(HasSubstr("goes on"), HasSubstr(fault.words)));
    set(fault.mended);
  }
  if (!fault.acknowledged.empty()) {
    const Outcome done = run_program(
        "prehend", {"service", "call", fault.acknowledged, "--registry", rig_->registry()}, 20s);
    EXPECT_EQ(done.exit_code, 0) << done.output;
  }
  EXPECT_TRUE(eventually([&] { return rig_->reset().success(); })) << rig_->output();
  expect_moves_after_reset();
}

INSTANTIATE_TEST_SUITE_P(Robots, EmergencyStopped, ::testing::ValuesIn(stopped_robots()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace prehend::testing
