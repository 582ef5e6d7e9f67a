// CAN buses: in this process, behind a serial adapter, and of the kernel where it has CAN.

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <thread>

#include "drivers/wire/can/can_bus.h"
#include "drivers/wire/can/can_interface.h"
#include "drivers/wire/can/in_process_can.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers {
namespace {

using namespace std::chrono_literals;
using Random = std::mt19937_64;

CanFrame random_frame(Random& random) {
  CanFrame frame{.identifier = static_cast<std::uint16_t>(random() % 0x800),
                 .size = static_cast<std::uint8_t>(random() % 9)};
  for (int i = 0; i < frame.size; ++i) frame.data[i] = static_cast<std::uint8_t>(random());
  return frame;
}

void check_frames(CanBus& from, CanBus& to, int count) {
  Random random(1);
  for (int i = 0; i < count; ++i) {
    const CanFrame frame = random_frame(random);
    ASSERT_EQ(from.send(frame), "");
    const auto input = to.receive(5s);
    ASSERT_TRUE(input) << i;
    ASSERT_TRUE(std::holds_alternative<CanFrame>(*input)) << i;
    ASSERT_EQ(std::get<CanFrame>(*input), frame) << i;
  }
}

CanEvent::Kind event_of(CanBus& bus) {
  const auto input = bus.receive(1s);
  EXPECT_TRUE(input && std::holds_alternative<CanEvent>(*input));
  return std::get<CanEvent>(*input).kind;
}

TEST(InProcessCanBus, CarriesFramesAndTellsOfBusOff) {
  const auto hub = InProcessCan::create();
  const auto a = hub->join(), b = hub->join();
  check_frames(*a, *b, 1000);
  check_frames(*b, *a, 1000);
  EXPECT_FALSE(a->receive(1ms));  // nobody hears himself
  hub->set_bus_off(true);
  EXPECT_EQ(event_of(*a), CanEvent::Kind::kBusOff);
  EXPECT_EQ(event_of(*b), CanEvent::Kind::kBusOff);
  EXPECT_EQ(a->send({}), "the controller is off the bus");
  hub->set_bus_off(false);
  EXPECT_EQ(event_of(*a), CanEvent::Kind::kRestarted);
  EXPECT_EQ(event_of(*b), CanEvent::Kind::kRestarted);
  check_frames(*a, *b, 10);
  hub->set_down(true);
  EXPECT_EQ(event_of(*a), CanEvent::Kind::kInterfaceDown);
  EXPECT_EQ(a->send({}), "the interface is down");
}

TEST(SlcanLines, BothWays) {
  const CanFrame frame{.identifier = 0x50C, .size = 3, .data = {0x03, 0x86, 0xFF}};
  EXPECT_EQ(to_slcan(frame), "t50C30386FF\r");
  EXPECT_EQ(from_slcan("t50C30386FF"), frame);
  EXPECT_EQ(from_slcan("t50C30386ff1234"), frame);  // with a time stamp
  EXPECT_EQ(to_slcan({.identifier = 1}), "t0010\r");
  Random random(3);
  for (int i = 0; i < 100000; ++i) {
    const CanFrame one = random_frame(random);
    std::string line = to_slcan(one);
    line.pop_back();
    ASSERT_EQ(from_slcan(line), one) << line;
  }
  for (const char* bad : {"", "t", "T0000050C0", "t50C9", "t50C1", "t50C1G0", "t8001FF", "r50C0",
                          "t50C30386FF123", "t-0C0", "z", "V1013"}) {
    EXPECT_FALSE(from_slcan(bad)) << bad;
  }
  EXPECT_EQ(slcan_rate(500000), '6');
  EXPECT_EQ(slcan_rate(1000000), '8');
  EXPECT_FALSE(slcan_rate(123456));
}

TEST(SlcanBus, CarriesFramesOverASerialLineAndFilters) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const std::string line = terminal->name();
  Slcan device(std::move(terminal), 0, {});
  const auto all = open_can_bus("slcan:" + line, 500000, {});
  check_frames(*all, device, 500);
  check_frames(device, *all, 500);
}

TEST(SlcanBus, WaitsOnBehindAnswersAndPieces) {
  PseudoTerminal adapter;
  const auto bus = open_can_bus("slcan:" + adapter.name(), 0, {});
  std::jthread pieces([&] {
    for (const std::string piece : {"\r\rz\r", "t70", "11AB", "\r"}) {
      std::this_thread::sleep_for(5ms);
      adapter.write({reinterpret_cast<const std::uint8_t*>(piece.data()), piece.size()}, 1s);
    }
  });
  const auto input = bus->receive(5s);
  ASSERT_TRUE(input);
  EXPECT_EQ(std::get<CanFrame>(*input), (CanFrame{.identifier = 0x701, .size = 1, .data = {0xAB}}));
}

TEST(SlcanBus, OpensTheAdapterAndTellsWhenItIsGone) {
  PseudoTerminal adapter;
  auto bus = open_can_bus("slcan:" + adapter.name(), 250000, {0x701});
  std::array<std::uint8_t, 64> buffer;
  std::string commands;
  while (commands.size() < 7) {
    const auto result = adapter.read(buffer, 1s);
    ASSERT_EQ(result.status, IoStatus::kOk);
    commands.append(reinterpret_cast<const char*>(buffer.data()), result.count);
  }
  EXPECT_EQ(commands, "C\rS5\rO\r");
  const std::string lines = "\r\rt7020\rz\rt7011AB\r\a";
  adapter.write({reinterpret_cast<const std::uint8_t*>(lines.data()), lines.size()}, 1s);
  const auto input = bus->receive(1s);
  ASSERT_TRUE(input);
  EXPECT_EQ(std::get<CanFrame>(*input), (CanFrame{.identifier = 0x701, .size = 1, .data = {0xAB}}));
  EXPECT_EQ(event_of(*bus), CanEvent::Kind::kDisturbed);  // the adapter refused something
  adapter.unplug();
  EXPECT_EQ(event_of(*bus), CanEvent::Kind::kClosed);
  EXPECT_NE(bus->send({}), "");
  bus.reset();
  adapter.plug();
  EXPECT_THROW(open_can_bus("slcan:" + adapter.name(), 123456, {}), geometry::InputError);
}

std::string error_of(const std::string& name, unsigned bit_rate) {
  try {
    open_can_bus(name, bit_rate, {});
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(SocketCanBus, SaysWhatIsMissing) {
  if (kernel_has_can()) {
    EXPECT_NE(error_of("can_no_such", 0).find("there is no CAN interface can_no_such"),
              std::string::npos);
    return;
  }
  EXPECT_NE(error_of("can0", 0).find("this kernel offers no CAN sockets"), std::string::npos);
}

// By socket_can/run.sh, where necessary in user-mode-linux.
TEST(SocketCanBus, CarriesFramesFiltersAndSurvivesTheInterfaceGoingDown) {
  if (!std::getenv("PREHEND_VCAN")) return;
  ASSERT_TRUE(kernel_has_can());
  const auto interface = find_can_interface("vcan0");
  ASSERT_TRUE(interface);
  EXPECT_EQ(interface->kind, "vcan");
  ASSERT_TRUE(interface->is_up);
  const auto a = open_can_bus("vcan0", 0, {}), b = open_can_bus("vcan0", 500000, {});
  check_frames(*a, *b, 1000);
  check_frames(*b, *a, 1000);
  const auto some = open_can_bus("vcan0", 0, {0x701, 0x301});
  for (const std::uint16_t id : {0x700, 0x701, 0x501, 0x301, 0x302}) {
    ASSERT_EQ(a->send({.identifier = id}), "");
  }
  EXPECT_EQ(std::get<CanFrame>(*some->receive(1s)).identifier, 0x701);
  EXPECT_EQ(std::get<CanFrame>(*some->receive(1s)).identifier, 0x301);
  EXPECT_FALSE(some->receive(10ms));
  ASSERT_EQ(std::system("ip link set vcan0 down"), 0);
  EXPECT_EQ(event_of(*some), CanEvent::Kind::kInterfaceDown);
  EXPECT_NE(a->send({}), "");
  EXPECT_NE(error_of("vcan0", 0).find("Bring it up with 'sudo ip link set vcan0 up'"),
            std::string::npos);
  ASSERT_EQ(std::system("ip link set vcan0 up"), 0);
  ASSERT_EQ(a->send({.identifier = 0x301}), "");
  EXPECT_EQ(std::get<CanFrame>(*some->receive(1s)).identifier, 0x301);
}

}  // namespace
}  // namespace prehend::drivers
