// What the kernel says of a CAN controller, as crafted frames; on a real socket by
// socket_can/run.sh.

#include <gtest/gtest.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <random>

#include "drivers/wire/can/can_bus.h"
#include "drivers/wire/can/raw_frame.h"

namespace prehend::drivers {
namespace {

using namespace std::chrono_literals;
using Kind = CanEvent::Kind;

can_frame error_frame(std::uint32_t classes, std::uint8_t controller = 0) {
  can_frame raw{};
  raw.can_id = CAN_ERR_FLAG | classes;
  raw.can_dlc = CAN_ERR_DLC;
  raw.data[1] = controller;
  return raw;
}

struct Case {
  can_frame raw;
  Kind kind;
  const char* words;
};

std::vector<Case> cases() {
  return {
      {error_frame(CAN_ERR_BUSOFF), Kind::kBusOff, "bus-off"},
      {error_frame(CAN_ERR_BUSOFF | CAN_ERR_CRTL | CAN_ERR_PROT, CAN_ERR_CRTL_TX_PASSIVE),
       Kind::kBusOff, "bus-off"},
      {error_frame(CAN_ERR_RESTARTED), Kind::kRestarted, "the controller was restarted"},
      {error_frame(CAN_ERR_RESTARTED | CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE), Kind::kRestarted,
       "the controller was restarted"},
      {error_frame(CAN_ERR_ACK), Kind::kDisturbed, "nobody acknowledges frames"},
      {error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW), Kind::kDisturbed, "lost"},
      {error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING), Kind::kDisturbed, "counts errors"},
      {error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE), Kind::kDisturbed, "error-passive"},
      {error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE), Kind::kRestarted, "no more errors"},
      {error_frame(CAN_ERR_PROT), Kind::kDisturbed, "errors on the wire"},
      {error_frame(CAN_ERR_TX_TIMEOUT | CAN_ERR_LOSTARB), Kind::kDisturbed, "errors on the wire"},
      {error_frame(0), Kind::kDisturbed, "errors on the wire"},
  };
}

void expect_event(const std::optional<CanInput>& input, const Case& expected) {
  ASSERT_TRUE(input && std::holds_alternative<CanEvent>(*input)) << expected.words;
  const auto& event = std::get<CanEvent>(*input);
  EXPECT_EQ(event.kind, expected.kind) << event.words;
  EXPECT_NE(event.words.find(expected.words), std::string::npos) << event.words;
}

TEST(CanErrorFrames, SayWhatHappenedToTheBus) {
  for (const Case& one : cases()) expect_event(input_of(one.raw), one);
}

TEST(CanErrorFrames, AreNeverTakenForData) {
  std::mt19937 random(7);
  for (int i = 0; i < 100000; ++i) {
    can_frame raw{};
    raw.can_id = random();
    raw.can_dlc = static_cast<std::uint8_t>(random());
    for (std::uint8_t& byte : raw.data) byte = static_cast<std::uint8_t>(random());
    const auto input = input_of(raw);
    const bool is_error = raw.can_id & CAN_ERR_FLAG;
    const bool is_odd = raw.can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG);
    ASSERT_EQ(input.has_value(), is_error || !is_odd);
    if (!input) continue;
    ASSERT_EQ(std::holds_alternative<CanEvent>(*input), is_error);
    if (is_error) continue;
    const auto& frame = std::get<CanFrame>(*input);
    ASSERT_LE(frame.size, 8);
    const can_frame back = raw_frame_of(frame);
    ASSERT_EQ(back.can_id, raw.can_id & CAN_SFF_MASK);
    ASSERT_EQ(std::memcmp(back.data, raw.data, frame.size), 0);
  }
}

// The virtual interface carries error frames as a controller's driver would raise them.
TEST(SocketCanBus, TellsOfBusOffAndRestart) {
  if (!std::getenv("PREHEND_VCAN")) return;
  const auto bus = open_can_bus("vcan0", 0, {0x701});
  const int injector = ::socket(PF_CAN, SOCK_RAW, CAN_RAW);
  ASSERT_GE(injector, 0);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex("vcan0"));
  ASSERT_EQ(::bind(injector, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  for (const Case& one : cases()) {
    if (one.raw.can_id == CAN_ERR_FLAG) continue;  // of no class: no driver raises it
    ASSERT_EQ(::write(injector, &one.raw, sizeof one.raw), ssize_t{sizeof one.raw}) << one.words;
    expect_event(bus->receive(5s), one);
  }
  const can_frame data = raw_frame_of({.identifier = 0x701, .size = 1, .data = {7}});
  ASSERT_EQ(::write(injector, &data, sizeof data), ssize_t{sizeof data});
  const auto input = bus->receive(5s);
  ASSERT_TRUE(input && std::holds_alternative<CanFrame>(*input));
  EXPECT_EQ(std::get<CanFrame>(*input).data[0], 7);
  ::close(injector);
}

}  // namespace
}  // namespace prehend::drivers
