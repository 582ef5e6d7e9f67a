// The whole loop through the real drivers and emulated devices: an object is picked up.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpa/inet.h>

#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "drivers/kuka_rsi/transport/udp_socket.h"
#include "drivers/wire/stream/tcp_server.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

using ::testing::HasSubstr;

struct WiredPlatform {
  std::string platform;
  std::vector<std::string> wires;  // arguments, of a test's own; LINES, UDP stand for what is free
  std::vector<std::string> said;   // by its drivers
  friend void PrintTo(const WiredPlatform& wired, std::ostream* out) { *out << wired.platform; }
};

class HardwareInTheLoop : public ::testing::TestWithParam<WiredPlatform> {};

std::string free_tcp_port() {
  const std::string name = drivers::TcpServer().name();
  return name.substr(name.rfind(':') + 1);
}

std::string free_udp_port() {
  const auto here = drivers::kuka_rsi::UdpSocket("127.0.0.1", 0).here();
  return std::to_string(ntohs(here.address.sin_port));
}

TEST_P(HardwareInTheLoop, PicksAnObjectUpThroughAllWires) {
  const ScratchFolder scratch;
  const std::string lines = scratch.path() / "line", out = scratch.path() / "out";
  std::vector<std::string> words{"launch",
                                 "launch/hil.yaml",
                                 "platform:=" + GetParam().platform,
                                 "lines:=" + lines,
                                 "camera_port:=" + free_tcp_port(),
                                 "out:=" + out,
                                 "--registry",
                                 drivers::TcpServer().name(),
                                 "--log-dir",
                                 (scratch.path() / "log").string()};
  for (std::string wire : GetParam().wires) {
    for (const auto& [word, value] :
         {std::pair<std::string, std::string>{"LINES", lines}, {"UDP", free_udp_port()}}) {
      if (const auto at = wire.find(word); at != std::string::npos) {
        wire.replace(at, word.size(), value);
      }
    }
    words.push_back(wire);
  }
  const Outcome outcome = run_program("prehend", words, std::chrono::seconds(200));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  std::ifstream file(out + "/summary.txt");
  const std::string summary(std::istreambuf_iterator<char>(file), {});
  EXPECT_THAT(summary, HasSubstr("success: "));
  // The report judges by the simulation's truth: lifted, moved, put down.
  EXPECT_THAT(summary, HasSubstr("was raised by"));
  EXPECT_THAT(outcome.output, HasSubstr("connected by prehend simulated depth camera"));
  for (const std::string& words : GetParam().said) EXPECT_THAT(outcome.output, HasSubstr(words));
}

INSTANTIATE_TEST_SUITE_P(
    Platforms, HardwareInTheLoop,
    ::testing::Values(WiredPlatform{"stage_pg70",
                                    {"can:=slcan:LINES_can"},
                                    {"connected by slcan:", "streaming 2 matrices, 168 texels",
                                     "FTS-2.0.1 on ", "no driver of this platform's arm"}},
                      WiredPlatform{
                          "kr5_sdh",
                          {"rsi_port:=UDP"},
                          {"RSI began: controller 127.0.0.1:", "answers: ",
                           "the hand answers: firmware", "streaming 6 matrices", "FTS-2.0.1 on "}},
                      WiredPlatform{"kr5_pg70",
                                    {"rsi_port:=UDP"},
                                    {"RSI began: controller 127.0.0.1:", "streaming 2 matrices",
                                     "FTS-2.0.1 on ", "no driver of this platform's hand"}},
                      WiredPlatform{"pa10_barrett",
                                    {},
                                    {"FTS-2.0.1 on ", "no driver of this platform's arm",
                                     "the hand is initialised"}}),
    [](const auto& wired) { return wired.param.platform; });

}  // namespace
}  // namespace prehend::testing
