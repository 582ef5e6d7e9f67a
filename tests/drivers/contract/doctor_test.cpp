// prehend doctor names what is wrong with a device's line, and the mend.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <sys/stat.h>
#include <unistd.h>

#include "drivers/barrett/emulator/gcl/hand.h"
#include "drivers/barrett/emulator/served_hand.h"
#include "drivers/dsa/driver/probe.h"
#include "drivers/dsa/emulator/controller.h"
#include "drivers/ft300/driver/probe.h"
#include "drivers/ft300/emulator/sensor.h"
#include "drivers/kuka_rsi/emulator/served_controller.h"
#include "drivers/pg70/driver/probe.h"
#include "drivers/pg70/emulator/served_module.h"
#include "drivers/sdh/driver/probe.h"
#include "drivers/sdh/emulator/hand.h"
#include "drivers/wire/can/can_interface.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/stream/line_users.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "drivers/wire/stream/tcp_server.h"
#include "prehend/graph/registry.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class DriversDoctor : public ::testing::Test {
 protected:
  /// Its page once it holds `text`, with the program running beside.
  std::string page_of(const std::string& program, const std::vector<std::string>& parameters,
                      const std::string& text) {
    std::vector<std::string> arguments{"--registry", registry_.endpoint()};
    for (const std::string& parameter : parameters) {
      arguments.push_back("--param");
      arguments.push_back(parameter);
    }
    const testing::Launched driver(program, arguments, scratch_.path() / (program + ".txt"));
    std::string page;
    eventually(
        [&] {
          page = testing::run_program("prehend", {"doctor", "--registry", registry_.endpoint()},
                                      std::chrono::seconds(20))
                     .output;
          return page.find(text) != std::string::npos;
        },
        std::chrono::seconds(30));
    return page;
  }

  testing::ScratchFolder scratch_;
  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
};

TEST_F(DriversDoctor, NamesTheMissingCanInterface) {
  const char* words =
      kernel_has_can() ? "there is no CAN interface can_none" : "this kernel offers no CAN sockets";
  const char* mend = kernel_has_can() ? "plug the adapter in" : "sudo modprobe can-raw";
  EXPECT_THAT(page_of("pg70", {"can:=can_none"}, words), AllOf(HasSubstr(words), HasSubstr(mend)));
}

TEST_F(DriversDoctor, NamesTheModuleThatDoesNotAnswer) {
  const PseudoTerminal nobody;
  EXPECT_THAT(page_of("pg70", {"can:=slcan:" + nobody.name(), "module_id:=13"}, "module 13"),
              AllOf(HasSubstr("module 13 does not answer on slcan:"),
                    HasSubstr("Check its supply, wiring and termination")));
}

TEST_F(DriversDoctor, NamesLinesThatCannotBeOpened) {
  EXPECT_THAT(page_of("dsa", {"line:=/dev/no_pads"}, "/dev/no_pads"),
              AllOf(HasSubstr("cannot open /dev/no_pads"), HasSubstr("ls /dev/serial/by-id")));
  EXPECT_THAT(page_of("ft300", {"line:=/dev/no_sensor"}, "/dev/no_sensor"),
              AllOf(HasSubstr("cannot open /dev/no_sensor"), HasSubstr("ls /dev/serial/by-id")));
}

// What the page says when it asks the devices itself, with no driver running.
class DoctorAsksDevices : public ::testing::Test {
 protected:
  testing::Outcome ask(std::vector<std::string> options) {
    options.insert(options.begin(), {"doctor", "--registry", registry_.endpoint()});
    return testing::run_program("prehend", options, std::chrono::seconds(60));
  }

  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
};

TEST_F(DoctorAsksDevices, AllThreeAnswer) {
  auto gripper_line = std::make_unique<PseudoTerminal>();
  auto pads_line = std::make_unique<PseudoTerminal>();
  auto sensor_line = std::make_unique<TcpServer>();
  const std::string can = "slcan:" + gripper_line->name(), dsa = pads_line->name(),
                    ft300 = sensor_line->name();
  pg70::SimpleGripper plant;
  auto bus = std::make_unique<Slcan>(std::move(gripper_line), 0, std::vector<std::uint16_t>{});
  pg70::ServedModule module(plant, {},
                            pg70::make_can_link(std::move(bus), 21, pg70::Side::kModule));
  ServedDevice<dsa::Controller> pads(dsa::ControllerOptions{}, std::move(pads_line));
  ft300::SensorOptions gateway;
  gateway.is_tcp = true;
  ServedDevice<ft300::Sensor> sensor(gateway, std::move(sensor_line));
  const std::vector<std::string> lines{"--can", can, "--dsa", dsa, "--ft300", ft300};
  std::vector<std::string> right = lines;
  right.insert(right.end(), {"--module", "21"});
  const auto good = ask(right);
  EXPECT_EQ(good.exit_code, 0) << good.output;
  EXPECT_THAT(good.output, AllOf(HasSubstr("module 21 on " + can + " answers"),
                                 HasSubstr("tactile controller on " + dsa + " answers: 2 pads"),
                                 HasSubstr("force sensor on " + ft300 + " answers: FTS-2.0.1")));
  const auto wrong = ask({"--can", can, "--module", "12", "--scan"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.output, AllOf(HasSubstr("module 12 does not answer on " + can),
                                  HasSubstr("module ids that answer on " + can + ": 21"),
                                  HasSubstr("-> module_id:=21")));
  module.with_module([](pg70::Module& asked, Time) {
    EXPECT_EQ(asked.motions() + asked.stops(), 0u);
    return 0;
  });
}

TEST_F(DoctorAsksDevices, SilentLinesAndMissingOnes) {
  const PseudoTerminal nobody, no_pads, no_sensor;
  const auto silent = ask(
      {"--can", "serial:" + nobody.name(), "--dsa", no_pads.name(), "--ft300", no_sensor.name()});
  EXPECT_EQ(silent.exit_code, 1);
  EXPECT_THAT(silent.output,
              AllOf(HasSubstr("module 12 does not answer on serial:" + nobody.name()),
                    HasSubstr("the tactile controller does not answer on " + no_pads.name()),
                    HasSubstr("the force sensor does not answer: " + no_sensor.name())));
  const auto missing =
      ask({"--can", "can_none", "--dsa", "/dev/no_pads", "--ft300", "/dev/no_sensor"});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.output,
              AllOf(HasSubstr(kernel_has_can() ? "there is no CAN interface can_none\n"
                                               : "this kernel offers no CAN sockets"),
                    HasSubstr("cannot open /dev/no_pads"), HasSubstr("cannot open /dev/no_sensor"),
                    HasSubstr("-> Check plug and name (ls /dev/serial/by-id)")));
}

// A scan sends to every id, which the other devices of a bus need not take well.
TEST_F(DriversDoctor, NamesWhatIsNoCamera) {
  const testing::Outcome doctor =
      testing::run_program("prehend",
                           {"doctor", "--registry", registry_.endpoint(), "--camera", "/dev/null",
                            "--camera", "/dev/video_none", "--depth-camera", "nobody.oni"},
                           std::chrono::seconds(20));
  EXPECT_EQ(doctor.exit_code, 1);
  // This process and others have /dev/null open, which does not make it a camera that is in use.
  EXPECT_THAT(doctor.output, AllOf(HasSubstr("error    camera: /dev/null is no camera"),
                                   HasSubstr("error    camera: there is no camera /dev/video_none"),
                                   HasSubstr("error    depth camera: there is no recording")));
}

TEST_F(DoctorAsksDevices, ScanOfASharedBusIsNotMadeUnasked) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const std::string line = "slcan:" + terminal->name();
  pg70::SimpleGripper plant;
  auto bus = std::make_unique<Slcan>(std::move(terminal), 0, std::vector<std::uint16_t>{});
  pg70::ServedModule module(plant, {},
                            pg70::make_can_link(std::move(bus), 21, pg70::Side::kModule));
  const std::vector<std::string> scan{"--can", line, "--module", "21", "--scan"};
  EXPECT_THAT(ask(scan).output, HasSubstr("module ids that answer on " + line + ": 21"));
  module.with_module([](pg70::Module& m, Time now) {  // somebody has it tell its state
    m.receive(pg70::encode(pg70::GetState{pg70::GetState::Cycle{0.02F, pg70::kWithAll}}), now);
  });
  const auto shared = ask(scan);
  EXPECT_THAT(shared.output, AllOf(HasSubstr("others share " + line +
                                             " (module 21 is in use), so the 255 module "
                                             "ids were not asked"),
                                   HasSubstr("--shared-bus")));
  EXPECT_THAT(shared.output, ::testing::Not(HasSubstr("module ids that answer")));
  std::vector<std::string> nevertheless = scan;
  nevertheless.push_back("--shared-bus");
  EXPECT_THAT(ask(nevertheless).output, HasSubstr("module ids that answer on " + line + ": 21"));
}

TEST_F(DoctorAsksDevices, NoPermissionIsNamedWithItsMend) {
  const PseudoTerminal pads, sensor;
  for (const auto* line : {&pads, &sensor}) ASSERT_EQ(::chmod(line->name().c_str(), 0), 0);
  // Root may open anything, so another user asks then.
  const bool is_root = ::geteuid() == 0;
  constexpr uid_t kNobody = 65534;
  if (is_root) {
    ASSERT_EQ(::seteuid(kNobody), 0);
  }
  const auto page = [&](auto probe) -> std::string {
    try {
      probe();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "no error";
  };
  const std::string of_pads = page([&] { dsa::probe(pads.name()); });
  const std::string of_sensor = page([&] { ft300::probe(sensor.name()); });
  const std::string of_gripper = page([&] { pg70::probe({"serial:" + pads.name(), 0, 12}); });
  if (is_root) {
    ASSERT_EQ(::seteuid(0), 0);
  }
  for (const std::string& words : {of_pads, of_sensor, of_gripper}) {
    EXPECT_THAT(words, AllOf(HasSubstr("no permission to open /dev/pts/"),
                             HasSubstr("sudo usermod -aG dialout $USER")));
  }
}

TEST_F(DoctorAsksDevices, LineOfARunningDriverIsLeftAlone) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const std::string line = terminal->name();
  ServedDevice<dsa::Controller> pads(dsa::ControllerOptions{}, std::move(terminal));
  EXPECT_TRUE(users_of_line(line).empty());  // this process serves it
  const testing::ScratchFolder scratch;
  const testing::Launched driver("dsa",
                                 {"--registry", registry_.endpoint(), "--param", "line:=" + line},
                                 scratch.path() / "dsa.txt");
  ASSERT_TRUE(
      eventually([&] { return pads.with_device([](auto& c, Time) { return c.is_streaming(); }); }));
  EXPECT_THAT(ask({"--dsa", line}).output,
              HasSubstr(line + " is in use by dsa (process " + std::to_string(driver.pid()) +
                        "), so it was not asked"));
}

TEST_F(DoctorAsksDevices, HearsWhetherAControllerOfAnArmSends) {
  int port = 0;
  {
    const kuka_rsi::UdpSocket any("127.0.0.1", 0);
    port = ntohs(any.here().address.sin_port);
  }
  const std::vector<std::string> options{"--rsi", std::to_string(port), "--rsi-host", "127.0.0.1"};
  EXPECT_THAT(ask(options).output,
              AllOf(HasSubstr("no controller sends to UDP 127.0.0.1:" + std::to_string(port)),
                    HasSubstr("RSI_EthernetConfig")));
  kuka_rsi::SimpleArm arm({0, -1.5, 1.5, 0, 1, 0});
  kuka_rsi::ControllerOptions controller;
  controller.lower.fill(-3);
  controller.upper.fill(3);
  controller.speed.fill(4);
  controller.late_limit = 1000000;  // nobody answers
  kuka_rsi::ServedOptions served;
  served.port = port;
  kuka_rsi::ServedController sends(arm, controller, served, [](const std::string&) {});
  const auto heard = ask(options);
  EXPECT_EQ(heard.exit_code, 0) << heard.output;
  EXPECT_THAT(heard.output, AllOf(HasSubstr("ok"), HasSubstr("arm: controller at 127.0.0.1:"),
                                  HasSubstr("axes at 0.0 -85.9")));
  const kuka_rsi::UdpSocket driver("127.0.0.1", port);
  EXPECT_THAT(ask(options).output, HasSubstr("UDP port " + std::to_string(port) + " is in use"));
}

TEST_F(DoctorAsksDevices, HandAnswersAndIsNotMoved) {
  auto end = std::make_unique<PseudoTerminal>();
  const std::string line = end->name();
  sdh::SimpleHand plant;
  sdh::HandOptions of_hand;
  of_hand.plant = &plant;
  ServedDevice<sdh::Hand> hand(of_hand, std::move(end));
  const auto good = ask({"--sdh", line});
  EXPECT_EQ(good.exit_code, 0) << good.output;
  EXPECT_THAT(good.output, HasSubstr("hand: SDH-2 on " + line +
                                     " answers: firmware 0.0.3.3, axes off, 25 degree Celsius"));
  hand.with_device([](sdh::Hand& h, Time) {
    EXPECT_EQ(h.moves() + h.stops(), 0u);
    EXPECT_FALSE(h.is_powered(0));
    h.set_mute(true);
    return 0;
  });
  const auto silent = ask({"--sdh", line});
  EXPECT_EQ(silent.exit_code, 1);
  EXPECT_THAT(silent.output,
              AllOf(HasSubstr("the hand does not answer on " + line),
                    HasSubstr("-> check its supply (24 V)"), HasSubstr("too hot to answer")));
  const auto missing = ask({"--sdh", "/dev/no_hand"});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.output, HasSubstr("cannot open /dev/no_hand"));
}

TEST_F(DoctorAsksDevices, BarrettHandAnswersAndIsNotMoved) {
  auto end = std::make_unique<PseudoTerminal>();
  const std::string bus = "slcan:" + end->name();
  barrett::ClutchHand plant;
  barrett::HandOptions of_hand;
  of_hand.plant = &plant;
  barrett::ServedHand hand(
      of_hand, std::make_unique<Slcan>(std::move(end), 0, std::vector<std::uint16_t>{}));
  const auto good = ask({"--barrett", bus});
  EXPECT_EQ(good.exit_code, 0) << good.output;
  EXPECT_THAT(good.output,
              AllOf(HasSubstr("hand: BarrettHand on " + bus + " answers: four pucks, firmware 174"),
                    HasSubstr("F1 is in monitor mode")));
  hand.with_hand([](barrett::Hand& h, Time) {
    EXPECT_EQ(h.moves() + h.stops(), 0u);
    h.set_mute(true);
  });
  const auto silent = ask({"--barrett", bus});
  EXPECT_EQ(silent.exit_code, 1);
  EXPECT_THAT(silent.output, AllOf(HasSubstr("the hand does not answer on " + bus),
                                   HasSubstr("-> check its supply (48 V)")));
  const auto missing = ask({"--barrett", "slcan:/dev/no_adapter"});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.output, HasSubstr("cannot open /dev/no_adapter"));
}

TEST_F(DoctorAsksDevices, BarrettHandOnASerialLineAnswersAndIsNotMoved) {
  auto end = std::make_unique<PseudoTerminal>();
  const std::string line = end->name();
  barrett::ClutchHand plant;
  barrett::gcl::HandOptions of_hand;
  of_hand.plant = &plant;
  of_hand.boot_time = 0;
  of_hand.host_baud = [terminal = end.get()] { return terminal->baud(); };
  ServedDevice<barrett::gcl::Hand> hand(of_hand, std::move(end));
  const auto good = ask({"--barrett", line});
  EXPECT_EQ(good.exit_code, 0) << good.output;
  EXPECT_THAT(good.output,
              AllOf(HasSubstr("hand: BarrettHand BH8-262 on " + line + " answers at 9600 baud"),
                    HasSubstr("not initialised")));
  hand.with_device([](barrett::gcl::Hand& h, Time) {
    EXPECT_EQ(h.moves() + h.aborts(), 0u);
    h.set_mute(true);
  });
  const auto silent = ask({"--barrett", line});
  EXPECT_EQ(silent.exit_code, 1);
  EXPECT_THAT(silent.output, AllOf(HasSubstr("the hand does not answer on " + line),
                                   HasSubstr("-> check its supply (24 V)")));
}

TEST_F(DriversDoctor, NamesTheBarrettHandThatDoesNotAnswerOnItsLine) {
  const PseudoTerminal nobody;
  EXPECT_THAT(page_of("barrett", {"model:=bh8_262", "line:=" + nobody.name()}, "does not answer"),
              AllOf(HasSubstr("the hand does not answer on " + nobody.name()),
                    HasSubstr("Check its supply (24 V)")));
}

TEST_F(DriversDoctor, ParametersOfAnotherBarrettHandAreRefusedByName) {
  struct Case {
    const char *model, *parameter, *words;
  };
  for (const Case& one :
       {Case{"bh8_280", "fast_baud:=38400", "fast_baud is a parameter of a BH8-262"},
        Case{"bh8_262", "can:=can1", "can is a parameter of a BH8-280"},
        Case{"bh8_262", "initialise:=done", "tells by itself"}}) {
    const auto outcome =
        testing::run_program("barrett",
                             {"--registry", registry_.endpoint(), "--param",
                              std::string("model:=") + one.model, "--param", one.parameter},
                             std::chrono::seconds(20));
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr(one.words));
  }
}

TEST_F(DriversDoctor, NamesTheBarrettHandThatDoesNotAnswer) {
  const PseudoTerminal nobody;
  EXPECT_THAT(page_of("barrett", {"can:=slcan:" + nobody.name()}, "does not answer"),
              AllOf(HasSubstr("the hand does not answer on slcan:" + nobody.name()),
                    HasSubstr("Check its supply (48 V)")));
}

TEST_F(DriversDoctor, PlatformWithoutABarrettHandIsRefusedByName) {
  for (const std::string platform : {"kr5_pg70", "stage_pg70", "kr5_sdh"}) {
    const auto outcome = testing::run_program(
        "barrett", {"--registry", registry_.endpoint(), "--param", "platform:=" + platform},
        std::chrono::seconds(20));
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    EXPECT_THAT(outcome.output,
                AllOf(HasSubstr("platform " + platform), HasSubstr("platform:=pa10_barrett")));
  }
}

TEST_F(DriversDoctor, NamesTheHandThatDoesNotAnswer) {
  const PseudoTerminal nobody;
  EXPECT_THAT(page_of("sdh", {"line:=" + nobody.name()}, "does not answer"),
              AllOf(HasSubstr("the hand does not answer on " + nobody.name()),
                    HasSubstr("Check its supply (24 V)")));
}

TEST_F(DriversDoctor, PlatformWithoutAnSdhIsRefusedByName) {
  for (const std::string platform : {"kr5_pg70", "stage_pg70", "pa10_barrett"}) {
    const auto outcome = testing::run_program(
        "sdh", {"--registry", registry_.endpoint(), "--param", "platform:=" + platform},
        std::chrono::seconds(20));
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    EXPECT_THAT(outcome.output,
                AllOf(HasSubstr("platform " + platform), HasSubstr("platform:=kr5_sdh")));
  }
}

TEST_F(DriversDoctor, NamesTheControllerThatDoesNotSend) {
  EXPECT_THAT(page_of("kuka_rsi", {"port:=49999"}, "no controller sends"),
              HasSubstr("no controller sends to UDP port 49999. Start its RSI program"));
}

TEST_F(DriversDoctor, StatesThatDoNotFitTheLineAreRefusedAtTheStart) {
  const auto outcome = testing::run_program(
      "pg70", {"--registry", registry_.endpoint(), "--param", "can:=serial:/dev/ttyS9"},
      std::chrono::seconds(20));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.output, AllOf(HasSubstr("a state every 0.02 s is too much for 9600 baud"),
                                    HasSubstr("Set state_period to at least 0.030")));
}

}  // namespace
}  // namespace prehend::drivers
