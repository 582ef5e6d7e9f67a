// Driver and emulated controller through real datagrams, in real time.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpa/inet.h>

#include "drivers/kuka_rsi/driver/device.h"
#include "drivers/kuka_rsi/driver/probe.h"
#include "drivers/kuka_rsi/emulator/served_controller.h"
#include "prehend/geometry/errors.h"
#include "tests/drivers/eventually.h"
#include "tests/drivers/kuka_rsi/virtual_robot.h"

namespace prehend::drivers::kuka_rsi {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

int free_port() { return ntohs(UdpSocket("127.0.0.1", 0).here().address.sin_port); }

class RsiDevice : public ::testing::Test {
 protected:
  RsiDevice() : port_(free_port()), arm_(home_of_kuka()) {
    controller_options_ = controller_of_kuka();
    controller_options_.late_limit = 200;  // of a machine that is busy with other tests
    controller_options_.answer_time = 0.012;
    served_.port = port_;
    served_.restart_pause = 0.5;
    options_.host = "127.0.0.1";
    options_.port = port_;
    options_.driver.late_limit = 100;
    options_.driver.loss_cycles = 30;
    options_.priority = 0;
  }
  void start_controller() {
    controller_ = std::make_unique<ServedController>(arm_, controller_options_, served_,
                                                     [](const std::string&) {});
  }
  void start_device() {
    device_ = std::make_unique<Device>(options_, limits_of_kuka(), notes_.taker());
  }
  bool holds() const {
    return eventually([&] { return device_->snapshot().state == State::kHolding; });
  }
  bool move(double a1, double duration) {
    const Snapshot now = device_->snapshot();
    Axes to = home_of_kuka();
    to[0] += a1;
    auto motion = std::make_unique<Motion>();
    motion->ticket = now.ticket + 1;
    motion->tolerance.fill(1);
    motion->set_points = set_points_of(way(now.set_point, to, duration), now.set_point,
                                       now.reference, limits_of_kuka(), options_.driver.cycle);
    return device_->start(std::move(motion));
  }

  const int port_;
  SimpleArm arm_;
  ControllerOptions controller_options_;
  ServedOptions served_;
  DeviceOptions options_;
  Notes notes_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<ServedController> controller_;
};

TEST_F(RsiDevice, MovesTheArmAndTellsHowLongAnswersTook) {
  start_device();
  start_controller();
  ASSERT_TRUE(holds());
  ASSERT_TRUE(move(0.5, 0.6));
  EXPECT_TRUE(eventually([&] { return device_->snapshot().end == Snapshot::End::kReached; }));
  EXPECT_NEAR(controller_->with_controller([](Controller& c) { return c.actual()[0]; }), 0.5, 5e-3);
  std::uint64_t answers = 0;
  const AnswerTimes times = device_->answer_times();
  for (const std::uint64_t count : times.counts) answers += count;
  EXPECT_GT(answers, 40u);
  EXPECT_GT(times.longest, 0);
  EXPECT_THAT(device_->peer(), HasSubstr("127.0.0.1:"));
}

TEST_F(RsiDevice, TakesControllersOfFourMilliseconds) {
  controller_options_.cycle = controller_options_.answer_time = options_.driver.cycle = 0.004;
  controller_options_.ipoc_step = 4;
  options_.driver.loss_cycles = 90;
  start_device();
  start_controller();
  ASSERT_TRUE(holds());
  ASSERT_TRUE(move(0.3, 0.5));
  EXPECT_TRUE(eventually([&] { return device_->snapshot().end == Snapshot::End::kReached; }));
}

TEST_F(RsiDevice, RefusesMotionsWithoutAController) {
  start_device();
  auto motion = std::make_unique<Motion>();
  motion->ticket = 1;
  motion->set_points = {home_of_kuka()};
  EXPECT_FALSE(device_->start(std::move(motion)));
  EXPECT_EQ(device_->snapshot().state, State::kSilent);
  EXPECT_EQ(device_->peer(), "");
}

TEST_F(RsiDevice, ServesTheControllerThatComesBackFromAnotherPort) {
  start_device();
  start_controller();
  ASSERT_TRUE(holds());
  const std::string before = device_->peer();
  controller_->with_controller([](Controller& c) { c.end("emergency stop"); });
  ASSERT_TRUE(eventually([&] { return device_->snapshot().state == State::kSilent; }));
  ASSERT_TRUE(holds());
  EXPECT_EQ(device_->snapshot().sessions, 2u);
  EXPECT_NE(device_->peer(), before);
}

TEST_F(RsiDevice, StrangersAreNotAnsweredAndMoveNothing) {
  start_device();
  start_controller();
  ASSERT_TRUE(holds());
  UdpSocket stranger("127.0.0.1", 0);
  for (const char* text : {"", "<Rob>", "<Rob><IPOC>99999999999</IPOC></Rob>"}) {
    stranger.send(text, peer_at("127.0.0.1", port_));
  }
  EXPECT_TRUE(eventually([&] { return device_->strangers() >= 3; }));
  EXPECT_EQ(device_->snapshot().state, State::kHolding);
  std::array<char, 100> buffer{};
  EXPECT_FALSE(stranger.receive(buffer, steady_now()).came);
}

TEST_F(RsiDevice, OnlyTheNamedControllerIsAnswered) {
  options_.controller = "127.0.0.9";
  start_device();
  start_controller();
  EXPECT_TRUE(eventually([&] { return device_->strangers() > 10; }));
  EXPECT_EQ(device_->snapshot().telegrams, 0u);
}

TEST_F(RsiDevice, PortThatIsTakenIsNamedWithTheMend) {
  start_device();
  try {
    Device(options_, limits_of_kuka(), notes_.taker());
    ADD_FAILURE();
  } catch (const geometry::InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("UDP 127.0.0.1:" + std::to_string(port_)),
                                    HasSubstr("Another program has it")));
  }
  options_.host = "here";
  EXPECT_THROW(start_device(), geometry::InputError);
}

TEST_F(RsiDevice, ProbeHearsTheControllerAndMovesNothing) {
  start_controller();
  const Probe heard = probe("127.0.0.1", port_);
  EXPECT_EQ(heard.result, Probe::Result::kAnswers) << heard.what;
  EXPECT_THAT(heard.what, AllOf(HasSubstr("controller at 127.0.0.1:"),
                                HasSubstr("axes at 0.0 -90.0 90.0 0.0 90.0 0.0 degrees")));
  EXPECT_EQ(controller_->with_controller([](Controller& c) { return c.actual(); }), home_of_kuka());
  controller_.reset();
  const Probe silent = probe("127.0.0.1", port_, {}, 0.1);
  EXPECT_EQ(silent.result, Probe::Result::kSilent);
  EXPECT_THAT(silent.what, HasSubstr("no controller sends"));
  controller_options_.sends_program = false;
  start_controller();
  EXPECT_EQ(probe("127.0.0.1", port_).result, Probe::Result::kWarns);
}

}  // namespace
}  // namespace prehend::drivers::kuka_rsi
