// The first look at a hand.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/sdh/driver/probe.h"
#include "drivers/sdh/emulator/hand.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "drivers/wire/stream/tcp_server.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers::sdh {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Result = Probe::Result;

TEST(SdhProbe, HandSaysWhoItIsAndMovesNothing) {
  for (const bool is_serial : {true, false}) {
    std::unique_ptr<ByteStream> end;
    if (is_serial) {
      end = std::make_unique<PseudoTerminal>();
    } else {
      end = std::make_unique<TcpServer>();
    }
    const std::string line = end->name();
    SimpleHand plant;
    HandOptions options;
    options.plant = &plant;
    ServedDevice<Hand> hand(options, std::move(end));
    const Probe answer = probe(line, kBaud, 10s);
    EXPECT_EQ(answer.result, Result::kAnswers) << answer.what;
    EXPECT_THAT(answer.what, HasSubstr("SDH-2 on " + line +
                                       " answers: firmware 0.0.3.3, axes off, 25 degree Celsius"));
    hand.with_device([](Hand& h, Time) {
      EXPECT_EQ(h.moves() + h.stops(), 0u);
      return 0;
    });
  }
}

TEST(SdhProbe, SilenceIsReportedWithItsMend) {
  const PseudoTerminal nobody;
  const Probe answer = probe(nobody.name(), kBaud, 50ms);
  EXPECT_EQ(answer.result, Result::kSilent);
  EXPECT_THAT(answer.what, HasSubstr("the hand does not answer on " + nobody.name()));
  EXPECT_THAT(answer.mend, HasSubstr("24 V"));
  EXPECT_THROW(probe("/dev/no_hand"), geometry::InputError);
}

TEST(SdhProbe, AnotherDeviceIsNamedAsSuch) {
  /// Says something of its own to whatever comes.
  struct Other {
    Other(const std::string& says, const std::function<void(Bytes)>& send)
        : words(says), sends(send) {}
    void receive(Bytes, Time) {
      sends({reinterpret_cast<const std::uint8_t*>(words.data()), words.size()});
    }
    void update(Time) {}
    std::string words;
    std::function<void(Bytes)> sends;
  };
  const struct {
    const char *says, *words;
  } cases[] = {{"\xAA\xAA\xAA\x01", "what comes is none of its lines"},
               {"VER=banana\r\n", "says that its firmware is 'banana'"},
               {"E13\r\n", "it says E13 unknown command"}};
  for (const auto& one : cases) {
    auto end = std::make_unique<PseudoTerminal>();
    const std::string line = end->name();
    ServedDevice<Other> other(std::string(one.says), std::move(end));
    const Probe answer = probe(line, kBaud, 100ms);
    EXPECT_EQ(answer.result, Result::kSilent);
    EXPECT_THAT(answer.what, HasSubstr(one.words));
    EXPECT_FALSE(answer.mend.empty());
  }
}

}  // namespace
}  // namespace prehend::drivers::sdh
