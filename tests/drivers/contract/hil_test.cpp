// The whole loop through the real drivers and emulated devices: an object is picked up.

#include <gtest/gtest.h>

#include <arpa/inet.h>

#include <fstream>
#include <iterator>

#include "drivers/kuka_rsi/transport/udp_socket.h"
#include "drivers/wire/stream/tcp_server.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

TEST(HardwareInTheLoop, PicksAnObjectUpThroughAllThreeWires) {
  const ScratchFolder scratch;
  std::string registry;
  {
    const drivers::TcpServer port;
    registry = port.name();
  }
  const std::string lines = scratch.path() / "line", out = scratch.path() / "out";
  const Outcome outcome = run_program(
      "prehend",
      {"launch", "launch/hil.yaml", "lines:=" + lines, "can:=slcan:" + lines + "_can",
       "out:=" + out, "--registry", registry, "--log-dir", (scratch.path() / "log").string()},
      std::chrono::seconds(200));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  std::ifstream file(out + "/summary.txt");
  const std::string summary(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(summary.find("success: "), std::string::npos) << summary;
  // The report judges by the simulation's truth: lifted, moved, put down.
  EXPECT_NE(summary.find("was raised by"), std::string::npos) << summary;
  for (const char* words :
       {"connected by slcan:", "streaming 2 matrices, 168 texels", "FTS-2.0.1 on "}) {
    EXPECT_NE(outcome.output.find(words), std::string::npos) << words << "\n" << outcome.output;
  }
}

TEST(HardwareInTheLoop, PicksAnObjectUpWithAnArmOverRsi) {
  const ScratchFolder scratch;
  std::string registry;
  {
    const drivers::TcpServer port;
    registry = port.name();
  }
  const int port = ntohs(drivers::kuka_rsi::UdpSocket("127.0.0.1", 0).here().address.sin_port);
  const std::string out = scratch.path() / "out";
  const Outcome outcome =
      run_program("prehend",
                  {"launch", "launch/hil.yaml", "arm:=rsi", "platform:=kr5_pg70",
                   "rsi_port:=" + std::to_string(port), "out:=" + out, "--registry", registry,
                   "--log-dir", (scratch.path() / "log").string()},
                  std::chrono::seconds(200));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  std::ifstream file(out + "/summary.txt");
  const std::string summary(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(summary.find("was raised by"), std::string::npos) << summary;
  for (const char* words : {"RSI began: controller 127.0.0.1:", "answers: "}) {
    EXPECT_NE(outcome.output.find(words), std::string::npos) << words << "\n" << outcome.output;
  }
}

}  // namespace
}  // namespace prehend::testing
