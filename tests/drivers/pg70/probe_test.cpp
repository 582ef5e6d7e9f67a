// The first look at a module: whether it is there, what is wrong, and that nothing moves by it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <thread>

#include "drivers/pg70/codec/can_framing.h"
#include "drivers/pg70/driver/probe.h"
#include "drivers/pg70/emulator/served_module.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/tcp_server.h"

namespace prehend::drivers::pg70 {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Result = Probe::Result;

struct Wire {
  std::unique_ptr<Link> module;
  LinkAddress address;
};

Wire slcan(std::uint8_t module) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const LinkAddress address{"slcan:" + terminal->name(), 500000, module};
  auto bus = std::make_unique<Slcan>(std::move(terminal), 0, std::vector<std::uint16_t>{});
  return {make_can_link(std::move(bus), module, Side::kModule), address};
}

Wire serial(std::uint8_t module) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const LinkAddress address{"serial:" + terminal->name(), 115200, module};
  return {make_serial_link(std::move(terminal), module, Side::kModule), address};
}

Wire serial_over_tcp(std::uint8_t module) {
  auto server = std::make_unique<TcpServer>();
  const LinkAddress address{"serial:" + server->name(), 115200, module};
  return {make_serial_link(std::move(server), module, Side::kModule), address};
}

Wire socket_can(std::uint8_t module) {
  const auto commands = can_identifier(Direction::kCommand, module);
  return {make_can_link(open_can_bus("vcan0", 0, {commands}), module, Side::kModule),
          {"vcan0", 0, module}};
}

struct Maker {
  const char* name;
  Wire (*make)(std::uint8_t module);
};

std::vector<Maker> makers() {
  std::vector<Maker> all{{"Slcan", slcan}, {"Serial", serial}, {"SerialOverTcp", serial_over_tcp}};
  if (std::getenv("PREHEND_VCAN")) all.push_back({"SocketCan", socket_can});  // socket_can/run.sh
  return all;
}

class Pg70Probe : public ::testing::TestWithParam<Maker> {
 protected:
  LinkAddress start(std::uint8_t module, const ModuleOptions& options = {}) {
    Wire wire = GetParam().make(module);
    module_ = std::make_unique<ServedModule>(plant_, options, std::move(wire.module));
    return wire.address;
  }
  void expect_nothing_moved() {
    module_->with_module([](Module& module, Time) {
      EXPECT_EQ(module.motions(), 0u);
      EXPECT_EQ(module.stops(), 0u);
      EXPECT_FALSE(module.is_moving());
      return 0;
    });
  }

  SimpleGripper plant_;
  std::unique_ptr<ServedModule> module_;
};

TEST_P(Pg70Probe, ModuleAnswersAndIsNotMoved) {
  const LinkAddress address = start(12);
  const Probe answer = probe(address, 5s);
  EXPECT_EQ(answer.result, Result::kAnswers);
  EXPECT_THAT(answer.what, HasSubstr("module 12 on " + address.line + " answers, at "));
  EXPECT_EQ(answer.mend, "");
  expect_nothing_moved();
}

TEST_P(Pg70Probe, TellsWhatHasToBeDoneFirst) {
  ModuleOptions options;
  options.referenced = false;
  const LinkAddress address = start(12, options);
  const Probe unreferenced = probe(address, 5s);
  EXPECT_EQ(unreferenced.result, Result::kWarns);
  EXPECT_THAT(unreferenced.what, HasSubstr("is not referenced"));
  EXPECT_THAT(unreferenced.mend, HasSubstr("/gripper/reference"));
  module_->with_module([](Module& module, Time now) {
    module.fail(ErrorCode::kTow, true, now);
    return 0;
  });
  const Probe faulty = probe(address, 5s);
  EXPECT_EQ(faulty.result, Result::kWarns);
  EXPECT_THAT(faulty.what, HasSubstr("ERROR TOW (0xDA)"));
  EXPECT_THAT(faulty.mend, HasSubstr("/gripper/acknowledge"));
  expect_nothing_moved();
}

TEST_P(Pg70Probe, AnotherIdIsFoundByScanning) {
  LinkAddress address = start(17);
  address.module = 12;
  const Probe answer = probe(address, 20ms);
  EXPECT_EQ(answer.result, Result::kSilent);
  EXPECT_THAT(answer.what, AllOf(HasSubstr("module 12 does not answer on " + address.line),
                                 HasSubstr("nothing else is heard")));
  EXPECT_THAT(answer.mend, HasSubstr("--scan"));
  EXPECT_THAT(find_modules(address), ElementsAre(17));
  expect_nothing_moved();
}

TEST_P(Pg70Probe, SilentModuleIsReported) {
  const LinkAddress address = start(12);
  module_->with_module([](Module& module, Time) {
    module.set_mute(true);
    return 0;
  });
  EXPECT_EQ(probe(address, 20ms).result, Result::kSilent);
}

INSTANTIATE_TEST_SUITE_P(Wires, Pg70Probe, ::testing::ValuesIn(makers()),
                         [](const auto& maker) { return maker.param.name; });

// What a probe sends to a module that talks by itself.
TEST(Pg70ProbeOnABusInUse, ModuleThatTalksIsNotAsked) {
  PseudoTerminal adapter;
  std::atomic<bool> ends = false;
  std::string sent;
  std::thread others([&] {
    std::array<std::uint8_t, 256> buffer;
    const std::string state = "t70C403950100\r";  // referenced, without floats
    while (!ends) {
      adapter.write({reinterpret_cast<const std::uint8_t*>(state.data()), state.size()}, 1s);
      const auto heard = adapter.read(buffer, 5ms);
      sent.append(reinterpret_cast<const char*>(buffer.data()), heard.count);
    }
  });
  const LinkAddress address{"slcan:" + adapter.name(), 500000, 12};
  const Probe same = probe(address);
  LinkAddress other = address;
  other.module = 13;
  const Probe wrong = probe(other, 20ms);
  ends = true;
  others.join();
  EXPECT_EQ(same.result, Result::kAnswers) << same.what;
  EXPECT_EQ(wrong.result, Result::kSilent);
  EXPECT_THAT(wrong.what, HasSubstr("module 13 does not answer"));
  EXPECT_THAT(wrong.what, HasSubstr("but 12 does"));
  EXPECT_EQ(wrong.mend, "module_id:=12, or give the module its id with Schunk's program");
  EXPECT_EQ(sent.find("t50C"), std::string::npos) << sent;  // 12 was never asked
  EXPECT_NE(sent.find("t50D"), std::string::npos) << sent;
}

TEST(Pg70ProbeOnABusInUse, WhatIsNoMessageIsToldApartFromSilence) {
  TcpServer chatter;
  std::atomic<bool> ends = false;
  std::thread others([&] {
    std::array<std::uint8_t, 256> buffer;
    const std::uint8_t noise[] = {0x55, 0x42, 0x13};
    while (!ends) {
      chatter.read(buffer, 5ms);
      chatter.write(noise, 1s);
    }
  });
  const Probe answer = probe({"serial:" + chatter.name(), 0, 12}, 50ms);
  ends = true;
  others.join();
  EXPECT_EQ(answer.result, Result::kSilent);
  EXPECT_THAT(answer.what, HasSubstr("what comes is no message of a module"));
  EXPECT_THAT(answer.mend, HasSubstr("baud rate"));
}

TEST(Pg70ProbeOnABusInUse, AdapterThatIsPulledOutIsReported) {
  PseudoTerminal adapter;
  std::thread hand([&] {
    std::array<std::uint8_t, 256> buffer;
    adapter.read(buffer, 5s);  // the first words to it
    adapter.unplug();
  });
  const Probe answer = probe({"slcan:" + adapter.name(), 500000, 12}, 50ms);
  hand.join();
  EXPECT_EQ(answer.result, Result::kSilent);
  EXPECT_THAT(answer.what, HasSubstr("is gone"));
}

}  // namespace
}  // namespace prehend::drivers::pg70
