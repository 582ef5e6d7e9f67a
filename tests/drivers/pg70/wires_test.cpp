// Driver and emulated module as threads of their own, over every kind of wire.

#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <thread>

#include "drivers/pg70/driver/device.h"
#include "drivers/pg70/emulator/served_module.h"
#include "drivers/wire/can/in_process_can.h"
#include "drivers/wire/can/raw_frame.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/faults/faulty_can.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/tcp_server.h"

namespace prehend::drivers::pg70 {
namespace {

using namespace std::chrono_literals;

constexpr std::uint8_t kModule = 12;

/// Both ends of a wire.
struct Wire {
  std::unique_ptr<Link> module;
  Device::Open open;
};

Wire in_process() {
  const auto hub = InProcessCan::create();
  return {make_can_link(hub->join(), kModule, Side::kModule),
          [hub] { return make_can_link(hub->join(), kModule, Side::kMaster); }};
}

Wire serial() {
  auto terminal = std::make_unique<PseudoTerminal>();
  const LinkAddress address{"serial:" + terminal->name(), 115200, kModule};
  return {make_serial_link(std::move(terminal), kModule, Side::kModule),
          [address] { return open_link(address); }};
}

Wire serial_over_tcp() {
  auto server = std::make_unique<TcpServer>();
  const LinkAddress address{"serial:" + server->name(), 0, kModule};
  return {make_serial_link(std::move(server), kModule, Side::kModule),
          [address] { return open_link(address); }};
}

Wire slcan() {
  auto terminal = std::make_unique<PseudoTerminal>();
  const LinkAddress address{"slcan:" + terminal->name(), 500000, kModule};
  return {
      make_can_link(std::make_unique<Slcan>(std::move(terminal), 0, std::vector<std::uint16_t>{}),
                    kModule, Side::kModule),
      [address] { return open_link(address); }};
}

Wire socket_can() {
  return {make_can_link(open_can_bus("vcan0", 0, {0x50C}), kModule, Side::kModule), [] {
            return open_link({"vcan0", 0, kModule});
          }};
}

struct Maker {
  const char* name;
  Wire (*make)();
};

std::vector<Maker> makers() {
  std::vector<Maker> all{{"InProcess", in_process},
                         {"Serial", serial},
                         {"SerialOverTcp", serial_over_tcp},
                         {"Slcan", slcan}};
  if (std::getenv("PREHEND_VCAN")) all.push_back({"SocketCan", socket_can});  // socket_can/run.sh
  return all;
}

class Pg70Wires : public ::testing::TestWithParam<Maker> {
 protected:
  void start(Wire wire, const DriverOptions& options = {}) {
    module_ = std::make_unique<ServedModule>(plant_, ModuleOptions{}, std::move(wire.module));
    device_ = make_device(wire.open, options);
  }
  std::unique_ptr<Device> make_device(Device::Open open, const DriverOptions& options = {}) {
    return std::make_unique<Device>(
        options, std::move(open), [](const Reading&) {},
        [this](bool, const std::string& words) {
          const std::lock_guard lock(mutex_);
          notes_.push_back(words);
        },
        0.02);
  }
  static bool eventually(const std::function<bool()>& condition, std::chrono::seconds time = 20s) {
    const auto end = std::chrono::steady_clock::now() + time;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(1ms);
    }
    return true;
  }
  bool becomes(DriverState state) {
    return eventually([&] { return device_->reading().state == state; });
  }
  MotionReport::Kind move(double opening) {
    std::uint64_t ticket = 0;
    const std::string refusal = device_->with_driver(
        [&](Driver& driver, Time now) { return driver.move_to(opening, 0.08, 0, now, ticket); });
    EXPECT_EQ(refusal, "");
    MotionReport::Kind kind = MotionReport::Kind::kRunning;
    eventually([&] {
      kind = device_->with_driver([&](Driver& d, Time) { return d.report(ticket).kind; });
      return kind != MotionReport::Kind::kRunning;
    });
    return kind;
  }
  bool noted(const std::string& part) {
    const std::lock_guard lock(mutex_);
    return std::ranges::any_of(
        notes_, [&](const std::string& words) { return words.find(part) != std::string::npos; });
  }
  std::uint64_t motions() {
    return module_->with_module([](Module& module, Time) { return module.motions(); });
  }

  std::mutex mutex_;
  std::vector<std::string> notes_;
  SimpleGripper plant_;
  std::unique_ptr<ServedModule> module_;
  std::unique_ptr<Device> device_;
};

TEST_P(Pg70Wires, MovesGripsFaultsAndIsAcknowledged) {
  start(GetParam().make());
  ASSERT_TRUE(becomes(DriverState::kStanding));
  EXPECT_EQ(move(0.05), MotionReport::Kind::kReached);
  EXPECT_NEAR(device_->reading().opening, 0.05, 3e-4);
  module_->with_module([this](Module&, Time) { plant_.put_object(0.045); });
  EXPECT_EQ(move(0.02), MotionReport::Kind::kBlocked);
  module_->with_module([](Module& m, Time now) { m.fail(ErrorCode::kTow, false, now); });
  ASSERT_TRUE(becomes(DriverState::kFault));
  EXPECT_TRUE(noted("ERROR TOW"));
  device_->with_driver([](Driver& driver, Time now) { driver.acknowledge(now); });
  ASSERT_TRUE(becomes(DriverState::kStanding));
  EXPECT_EQ(device_->damaged_messages(), 0u);
}

// Measured from outside: from the loss of its replies to its standing still.
TEST_P(Pg70Wires, LostRepliesStopItWithinTwoWatchdogPeriods) {
  DriverOptions options;
  options.watchdog = options.loss_time = 1.0;  // long beside what a loaded machine adds
  start(GetParam().make(), options);
  ASSERT_TRUE(becomes(DriverState::kStanding));
  std::uint64_t ticket = 0;
  device_->with_driver([&](Driver& d, Time now) { d.move_to(0.0, 0.01, 0, now, ticket); });
  ASSERT_TRUE(eventually([&] { return device_->reading().moving; }));
  const Time lost = module_->with_module([](Module& module, Time now) {
    module.set_mute(true);
    return now;
  });
  ASSERT_TRUE(eventually([&] {
    return !module_->with_module([](Module& module, Time) { return module.is_moving(); });
  }));
  const double seconds = to_seconds(steady_now() - lost);
  RecordProperty("seconds_from_loss_to_stop", std::to_string(seconds));
  EXPECT_LE(seconds, 2 * options.watchdog);
}

TEST_P(Pg70Wires, EndOfTheDriverStopsTheGripperAndANewOneResumesNothing) {
  Wire wire = GetParam().make();
  const Device::Open open = wire.open;
  start(std::move(wire));
  ASSERT_TRUE(becomes(DriverState::kStanding));
  std::uint64_t ticket = 0;
  device_->with_driver([&](Driver& d, Time now) { d.move_to(0.0, 0.01, 0, now, ticket); });
  ASSERT_TRUE(eventually([&] { return device_->reading().moving; }));
  device_.reset();
  EXPECT_TRUE(eventually(
      [&] {
        return !module_->with_module([](Module& module, Time) { return module.is_moving(); });
      },
      1s));
  const auto before = motions();
  device_ = make_device(open);
  ASSERT_TRUE(becomes(DriverState::kStanding));
  EXPECT_EQ(motions(), before);
}

INSTANTIATE_TEST_SUITE_P(All, Pg70Wires, ::testing::ValuesIn(makers()),
                         [](const auto& maker) { return maker.param.name; });

using Pg70Wire = Pg70Wires;

TEST_F(Pg70Wire, BusOffIsReportedAndRecovered) {
  const auto hub = InProcessCan::create();
  start({make_can_link(hub->join(), kModule, Side::kModule),
         [hub] { return make_can_link(hub->join(), kModule, Side::kMaster); }});
  ASSERT_TRUE(becomes(DriverState::kStanding));
  hub->set_bus_off(true);
  ASSERT_TRUE(becomes(DriverState::kDisconnected));
  EXPECT_TRUE(noted("bus-off; nothing can be sent"));
  hub->set_bus_off(false);
  ASSERT_TRUE(becomes(DriverState::kStanding));
}

TEST_F(Pg70Wire, InterfaceThatGoesDownAndUpIsUsedAgain) {
  const auto hub = InProcessCan::create();
  start({make_can_link(hub->join(), kModule, Side::kModule),
         [hub] { return make_can_link(hub->join(), kModule, Side::kMaster); }});
  ASSERT_TRUE(becomes(DriverState::kStanding));
  hub->set_down(true);
  ASSERT_TRUE(becomes(DriverState::kDisconnected));
  hub->set_down(false);
  ASSERT_TRUE(becomes(DriverState::kStanding));
}

/// Passes raw frames of the kernel through the parser of CAN sockets.
class CraftedCan : public CanBus {
 public:
  explicit CraftedCan(std::unique_ptr<CanBus> bus) : bus_(std::move(bus)) {}
  void inject(std::uint32_t classes) {
    can_frame raw{};
    raw.can_id = CAN_ERR_FLAG | classes;
    raw.can_dlc = CAN_ERR_DLC;
    const std::lock_guard lock(mutex_);
    raw_.push_back(raw);
  }
  std::optional<CanInput> receive(std::chrono::nanoseconds timeout) override {
    {
      const std::lock_guard lock(mutex_);
      if (!raw_.empty()) {
        const can_frame raw = raw_.front();
        raw_.erase(raw_.begin());
        is_off_ = is_off_ ? !(raw.can_id & CAN_ERR_RESTARTED) : (raw.can_id & CAN_ERR_BUSOFF) != 0;
        return input_of(raw);
      }
    }
    auto input = bus_->receive(timeout);
    return is_off_ ? std::nullopt : input;  // off the bus nothing is heard
  }
  std::string send(const CanFrame& frame) override {
    return is_off_ ? "off the bus" : bus_->send(frame);
  }
  const std::string& name() const override { return bus_->name(); }

 private:
  std::unique_ptr<CanBus> bus_;
  std::mutex mutex_;  // guards raw_
  std::vector<can_frame> raw_;
  std::atomic<bool> is_off_ = false;
};

// As a controller tells it: error frames of the kernel. The gripper moves on meanwhile, and is
// stopped by the first message after the restart.
TEST_F(Pg70Wire, BusOffByErrorFramesIsReportedAndEndsInAStop) {
  const auto hub = InProcessCan::create();
  CraftedCan* bus = nullptr;
  start({make_can_link(hub->join(), kModule, Side::kModule), [&] {
           auto crafted = std::make_unique<CraftedCan>(hub->join());
           bus = crafted.get();
           return make_can_link(std::move(crafted), kModule, Side::kMaster);
         }});
  ASSERT_TRUE(becomes(DriverState::kStanding));
  std::uint64_t ticket = 0;
  device_->with_driver([&](Driver& d, Time now) { d.move_to(0.0, 0.002, 0, now, ticket); });
  ASSERT_TRUE(becomes(DriverState::kMoving));
  const auto stops = [this] {
    return module_->with_module([](Module& module, Time) { return module.stops(); });
  };
  const auto stops_before = stops();
  bus->inject(CAN_ERR_CRTL | CAN_ERR_PROT);
  ASSERT_TRUE(eventually([&] { return noted("the controller counts errors on the wire"); }));
  EXPECT_EQ(device_->reading().state, DriverState::kMoving);  // frames still pass
  bus->inject(CAN_ERR_BUSOFF | CAN_ERR_CRTL);
  ASSERT_TRUE(becomes(DriverState::kDisconnected));
  EXPECT_TRUE(noted("bus-off: too many errors on the wire"));
  EXPECT_EQ(device_->with_driver([&](Driver& d, Time) { return d.report(ticket).kind; }),
            MotionReport::Kind::kFailed);
  EXPECT_TRUE(module_->with_module([](Module& module, Time) { return module.is_moving(); }));
  bus->inject(CAN_ERR_RESTARTED);
  ASSERT_TRUE(becomes(DriverState::kStanding));
  EXPECT_GT(stops(), stops_before);
  EXPECT_GT(device_->reading().opening, 0.01);  // a speed of 2 mm/s would take half a minute
}

TEST_F(Pg70Wire, AnotherModuleIdGetsNoCommandAndIsNotHeard) {
  const auto hub = InProcessCan::create();
  start({make_can_link(hub->join(), kModule + 1, Side::kModule),
         [hub] { return make_can_link(hub->join(), kModule, Side::kMaster); }});
  std::this_thread::sleep_for(300ms);
  EXPECT_EQ(device_->reading().state, DriverState::kConnecting);
  EXPECT_EQ(module_->with_module([](Module& m, Time) { return m.stops(); }), 0u);
}

TEST_F(Pg70Wire, SerialLineThatIsUnpluggedIsOpenedAgain) {
  auto terminal = std::make_unique<PseudoTerminal>(std::filesystem::temp_directory_path() /
                                                   ("prehend_pg70_" + std::to_string(::getpid())));
  PseudoTerminal& line = *terminal;
  const LinkAddress address{"serial:" + terminal->name(), 115200, kModule};
  start({make_serial_link(std::move(terminal), kModule, Side::kModule),
         [address] { return open_link(address); }});
  ASSERT_TRUE(becomes(DriverState::kStanding));
  module_->with_module([&](Module&, Time) { line.unplug(); });
  ASSERT_TRUE(becomes(DriverState::kDisconnected));
  ASSERT_TRUE(eventually([&] { return noted("cannot open"); }));
  module_->with_module([&](Module&, Time) { line.plug(); });
  ASSERT_TRUE(becomes(DriverState::kStanding));
}

TEST_F(Pg70Wire, BadFramesNeverMakeItUnusable) {
  const auto hub = InProcessCan::create();
  auto bus = std::make_unique<FaultyCan>(hub->join());
  FaultyCan& faults = *bus;
  start({make_can_link(std::move(bus), kModule, Side::kModule),
         [hub] { return make_can_link(hub->join(), kModule, Side::kMaster); }});
  ASSERT_TRUE(becomes(DriverState::kStanding));
  faults.set_faults({.dropped = 0.05, .duplicated = 0.05, .late = 0.05, .delay = 5ms});
  int reached = 0;
  for (int i = 0; i < 8; ++i) reached += move(i % 2 ? 0.06 : 0.055) == MotionReport::Kind::kReached;
  EXPECT_GE(reached, 4);
  EXPECT_GT(device_->damaged_messages(), 0u);
  faults.set_faults({});
  ASSERT_TRUE(becomes(DriverState::kStanding));
  EXPECT_EQ(move(0.05), MotionReport::Kind::kReached);
}

}  // namespace
}  // namespace prehend::drivers::pg70
