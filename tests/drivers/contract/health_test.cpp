// What drivers say of their health while their devices and lines misbehave, and afterwards.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <mutex>

#include "drivers/dsa/emulator/controller.h"
#include "drivers/ft300/emulator/sensor.h"
#include "drivers/pg70/emulator/served_module.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/faults/faulty_can.h"
#include "drivers/wire/faults/faulty_stream.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "msgs/actions.pb.h"
#include "msgs/graph.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers {
namespace {

using namespace std::chrono_literals;
using msgs::graph::Diagnostic;
using ::testing::HasSubstr;

class DriverHealth : public ::testing::Test {
 protected:
  DriverHealth()
      : node_(options()),
        diagnostics_(node_.subscribe<Diagnostic>("/diagnostics", graph::QoS::queue(100),
                                                 [this](const graph::Received<Diagnostic>& word) {
                                                   const std::lock_guard lock(mutex_);
                                                   last_[word->node()] = *word;
                                                 })) {
    node_.spin_in_background();
  }
  void start(const std::string& program, const std::string& parameter,
             const std::string& device_topic) {
    driver_ = std::make_unique<testing::Launched>(
        program, std::vector<std::string>{"--registry", registry_.endpoint(), "--param", parameter},
        scratch_.path() / "driver.txt");
    status_ = node_.subscribe<msgs::DeviceStatus>(
        device_topic, graph::QoS::queue(10),
        [this](const graph::Received<msgs::DeviceStatus>& status) {
          const std::lock_guard lock(mutex_);
          last_status_ = *status;
        });
  }
  Diagnostic word_of(const std::string& node) {
    const std::lock_guard lock(mutex_);
    return last_[node];
  }
  msgs::DeviceStatus status() {
    const std::lock_guard lock(mutex_);
    return last_status_;
  }
  bool becomes(const std::string& node, msgs::graph::HealthLevel level, const std::string& part) {
    const bool became = eventually(
        [&] {
          const Diagnostic word = word_of(node);
          return word.level() == level && word.text().find(part) != std::string::npos;
        },
        30s);
    if (!became) ADD_FAILURE() << word_of(node).ShortDebugString() << "\n" << driver_->output();
    return became;
  }

  testing::ScratchFolder scratch_;
  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
  graph::Node node_;

 private:
  graph::NodeOptions options() const {
    graph::NodeOptions options;
    options.name = "observer";
    options.registry = registry_.endpoint();
    return options;
  }
  std::mutex mutex_;  // guards what follows
  std::map<std::string, Diagnostic> last_;
  msgs::DeviceStatus last_status_;
  graph::Subscription diagnostics_, status_;

 protected:
  std::unique_ptr<testing::Launched> driver_;
};

// It stayed at "error" when frames came again, and at "ok" while a fifth of them was damaged.
TEST_F(DriverHealth, OfThePadsFollowsTheLine) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const std::string line = terminal->name();
  auto stream = std::make_unique<FaultyStream>(std::move(terminal));
  FaultyStream& faults = *stream;
  ServedDevice<dsa::Controller> pads(dsa::ControllerOptions{}, std::move(stream));
  start("dsa", "line:=" + line, "/tactile/device");
  ASSERT_TRUE(becomes("dsa", msgs::graph::HEALTH_OK, "streaming"));
  for (int i = 0; i < 2; ++i) {
    pads.with_device([](auto& controller, Time) { controller.set_silent(true); });
    ASSERT_TRUE(becomes("dsa", msgs::graph::HEALTH_ERROR, "no tactile frame"));
    pads.with_device([](auto& controller, Time) { controller.set_silent(false); });
    ASSERT_TRUE(becomes("dsa", msgs::graph::HEALTH_OK, "streaming"));
  }
  faults.set_faults({.corrupted = 0.2});
  ASSERT_TRUE(becomes("dsa", msgs::graph::HEALTH_WARNING, "the line is bad"));
  EXPECT_TRUE(eventually([&] { return status().damaged() > 0 && status().damaged_part() > 0.01; }));
  EXPECT_EQ(status().state(), "streaming");
  faults.set_faults({});
  EXPECT_TRUE(becomes("dsa", msgs::graph::HEALTH_OK, "streaming"));
  // Whole frames that vanish leave no damaged byte behind.
  faults.set_faults({.dropped = 0.2});
  ASSERT_TRUE(becomes("dsa", msgs::graph::HEALTH_WARNING, "the line is bad"));
  faults.set_faults({});
  EXPECT_TRUE(becomes("dsa", msgs::graph::HEALTH_OK, "streaming"));
}

TEST_F(DriverHealth, OfTheForceSensorFollowsTheLine) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const std::string line = terminal->name();
  auto stream = std::make_unique<FaultyStream>(std::move(terminal));
  FaultyStream& faults = *stream;
  ServedDevice<ft300::Sensor> sensor(ft300::SensorOptions{}, std::move(stream));
  start("ft300", "line:=" + line, "/wrench/device");
  ASSERT_TRUE(becomes("ft300", msgs::graph::HEALTH_OK, "measuring"));
  faults.set_faults({.corrupted = 0.1});
  ASSERT_TRUE(becomes("ft300", msgs::graph::HEALTH_WARNING, "the line is bad"));
  EXPECT_TRUE(eventually([&] { return status().damaged() > 0; }));
  faults.set_faults({});
  ASSERT_TRUE(becomes("ft300", msgs::graph::HEALTH_OK, "measuring"));
  sensor.with_device([](auto& s, Time) { s.set_silent(true); });
  ASSERT_TRUE(becomes("ft300", msgs::graph::HEALTH_ERROR, ""));
  sensor.with_device([](auto& s, Time) { s.set_silent(false); });
  EXPECT_TRUE(becomes("ft300", msgs::graph::HEALTH_OK, "measuring"));
}

TEST_F(DriverHealth, OfTheGripperFollowsLineAndDevice) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const std::string line = terminal->name();
  auto bus = std::make_unique<FaultyCan>(
      std::make_unique<Slcan>(std::move(terminal), 0, std::vector<std::uint16_t>{}));
  FaultyCan& faults = *bus;
  pg70::SimpleGripper plant;
  pg70::ServedModule module(plant, {},
                            pg70::make_can_link(std::move(bus), 12, pg70::Side::kModule));
  start("pg70", "can:=slcan:" + line, "/gripper/device");
  ASSERT_TRUE(becomes("pg70", msgs::graph::HEALTH_OK, "standing"));
  faults.set_faults({.dropped = 0.1});
  ASSERT_TRUE(becomes("pg70", msgs::graph::HEALTH_WARNING, "the line is bad"));
  EXPECT_TRUE(eventually([&] { return status().damaged() > 0; }));
  EXPECT_GT(status().messages(), 0u);
  faults.set_faults({});
  ASSERT_TRUE(becomes("pg70", msgs::graph::HEALTH_OK, "standing"));

  module.with_module(
      [](pg70::Module& m, Time now) { m.fail(pg70::ErrorCode::kCurrent, true, now); });
  ASSERT_TRUE(becomes("pg70", msgs::graph::HEALTH_ERROR, "ERROR CURRENT"));
  EXPECT_TRUE(eventually([&] { return status().error_code() == 0xDE; }));
  const auto acknowledge = node_.client<msgs::Empty, msgs::Acknowledge>("/gripper/acknowledge");
  EXPECT_TRUE(acknowledge.call({}, 10s)->success());
  ASSERT_TRUE(becomes("pg70", msgs::graph::HEALTH_WARNING, "the cause persists of ERROR CURRENT"));
  EXPECT_TRUE(eventually([&] { return status().warning_code() == 0xDE; }));
  module.with_module([](pg70::Module& m, Time now) { m.mend(now); });
  EXPECT_TRUE(becomes("pg70", msgs::graph::HEALTH_OK, "standing"));
}

// The words of a start and an end at which nothing is wrong: the device's line comes a little later
// than the driver, and the driver ends first.
TEST_F(DriverHealth, NothingIsWrongAtAStartBesideTheDevice) {
  const std::string line = scratch_.path() / "pads";
  start("dsa", "line:=" + line, "/tactile/device");
  ASSERT_TRUE(eventually([&] { return word_of("dsa").node() == "dsa"; }));
  ServedDevice<dsa::Controller> pads(dsa::ControllerOptions{},
                                     std::make_unique<PseudoTerminal>(line));
  ASSERT_TRUE(becomes("dsa", msgs::graph::HEALTH_OK, "streaming"));
  driver_->send_signal(SIGINT);
  EXPECT_EQ(driver_->wait(20s), 0);
  EXPECT_THAT(driver_->output(), ::testing::Not(HasSubstr("cannot open")));
  EXPECT_THAT(driver_->output(), ::testing::Not(HasSubstr("is gone")));
}

// They were declared after what ends the listing.
TEST(EmulatorsHelp, ListsEveryFault) {
  const std::map<std::string, std::vector<std::string>> faults{
      {"pg70_emulator", {"mute", "stuck", "reboot", "deaf_to", "fault"}},
      {"dsa_emulator", {"silent", "deaf", "reboot", "dead_texel", "matrices", "pads"}},
      {"ft300_emulator", {"silent", "reboot"}}};
  for (const auto& [program, names] : faults) {
    const auto help = testing::run_program(program, {"--help"}, 20s);
    EXPECT_EQ(help.exit_code, 0) << program;
    for (const std::string& name : names) EXPECT_THAT(help.output, HasSubstr("  " + name));
    for (const char* name : {"dropped", "duplicated", "corrupted", "late", "delay"}) {
      EXPECT_THAT(help.output, HasSubstr(std::string("  ") + name));
    }
  }
}

}  // namespace
}  // namespace prehend::drivers
