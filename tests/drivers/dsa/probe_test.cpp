// The first look at a tactile controller.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <thread>

#include "drivers/dsa/driver/probe.h"
#include "drivers/dsa/emulator/controller.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "drivers/wire/stream/tcp_server.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers::dsa {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Result = Probe::Result;
using Served = ServedDevice<Controller>;

TEST(DsaProbe, ControllerAnswersOnASerialLineAndOverTcp) {
  for (const bool is_serial : {true, false}) {
    std::unique_ptr<ByteStream> end;
    if (is_serial) {
      end = std::make_unique<PseudoTerminal>();
    } else {
      end = std::make_unique<TcpServer>();
    }
    const std::string line = end->name();
    Served device(ControllerOptions{}, std::move(end));
    const Probe answer = probe(line, 115200, 10s);
    EXPECT_EQ(answer.result, Result::kAnswers);
    EXPECT_THAT(answer.what, HasSubstr("tactile controller on " + line + " answers: 2 pads"));
    EXPECT_THAT(answer.what, HasSubstr("firmware 300"));
    EXPECT_FALSE(device.with_device([](Controller& c, Time) { return c.is_streaming(); }));
  }
}

TEST(DsaProbe, StreamThatRunsIsHeardAndGoesOn) {
  auto terminal = std::make_unique<PseudoTerminal>();
  const std::string line = terminal->name();
  Served device(ControllerOptions{}, std::move(terminal));
  device.with_device([](Controller& controller, Time now) {
    const Payload start = encode(Acquisition{Acquisition::kAcquire | Acquisition::kRunLength, 30});
    controller.receive(encode_packet(static_cast<std::uint8_t>(PacketId::kAcquisition), start),
                       now);
    return 0;
  });
  const Probe answer = probe(line, 115200, 10s);
  EXPECT_EQ(answer.result, Result::kAnswers) << answer.what;
  EXPECT_TRUE(device.with_device([](Controller& c, Time) { return c.is_streaming(); }));
}

TEST(DsaProbe, SilenceIsReported) {
  const PseudoTerminal nobody;
  const Probe answer = probe(nobody.name(), 115200, 50ms);
  EXPECT_EQ(answer.result, Result::kSilent);
  EXPECT_EQ(answer.what, "the tactile controller does not answer on " + nobody.name());
  EXPECT_THAT(answer.mend, HasSubstr("wait 10 s after power-on"));
}

// What somebody says all the time, without listening.
Probe probe_of_chatter(const std::string& words) {
  TcpServer line;
  std::atomic<bool> ends = false;
  std::thread others([&] {
    std::array<std::uint8_t, 256> buffer;
    while (!ends) {
      line.read(buffer, 5ms);
      line.write({reinterpret_cast<const std::uint8_t*>(words.data()), words.size()}, 1s);
    }
  });
  const Probe answer = probe(line.name(), 115200, 100ms);
  ends = true;
  others.join();
  return answer;
}

TEST(DsaProbe, StartingUpAndOtherDevicesAreToldApart) {
  const Probe starting = probe_of_chatter("\x1b[5n");
  EXPECT_EQ(starting.result, Result::kSilent);
  EXPECT_THAT(starting.what, HasSubstr("it is starting up"));
  EXPECT_EQ(starting.mend, "ask again in 10 s");
  const Probe other = probe_of_chatter("$GPGGA,");
  EXPECT_EQ(other.result, Result::kSilent);
  EXPECT_THAT(other.what, HasSubstr("what comes is none of its packets"));
  EXPECT_THAT(other.mend, HasSubstr("115200"));
}

TEST(DsaProbe, RefusalIsReportedInWords) {
  const auto refusal = encode_packet(static_cast<std::uint8_t>(PacketId::kControllerInfo),
                                     encode_status(static_cast<std::uint16_t>(Status::kNoSensor)));
  const Probe answer =
      probe_of_chatter({reinterpret_cast<const char*>(refusal.data()), refusal.size()});
  EXPECT_EQ(answer.result, Result::kSilent);
  EXPECT_THAT(answer.what, HasSubstr("no sensor (2)"));
}

TEST(DsaProbe, LineThatIsNotThereIsTheCallersMatter) {
  EXPECT_THROW(probe("/dev/no_pads"), geometry::InputError);
}

}  // namespace
}  // namespace prehend::drivers::dsa
