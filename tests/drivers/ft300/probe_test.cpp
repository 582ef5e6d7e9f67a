// The first look at a force sensor.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "drivers/ft300/driver/probe.h"
#include "drivers/ft300/emulator/sensor.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "drivers/wire/stream/tcp_server.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers::ft300 {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Result = Probe::Result;

constexpr unsigned kBaud = 19200;
constexpr double kPatience = 10;  // s; an answer comes long before

class Ft300Probe : public ::testing::Test {
 protected:
  template <class Work>
  auto with_sensor(Work&& work) {
    return sensor_->with_device(work);
  }
  /// The line of a sensor.
  std::string start(const SensorOptions& options) {
    std::unique_ptr<ByteStream> end;
    if (options.is_tcp) {
      end = std::make_unique<TcpServer>();
    } else {
      end = std::make_unique<PseudoTerminal>();
    }
    const std::string line = end->name();
    sensor_ = std::make_unique<ServedDevice<Sensor>>(options, std::move(end));
    with_sensor([](Sensor& sensor, Time) { sensor.set_measurement({{1, -2, -9.81}, {}}); });
    return line;
  }
  bool streams() {
    return with_sensor([](Sensor& sensor, Time) { return sensor.is_streaming(); });
  }

  std::unique_ptr<ServedDevice<Sensor>> sensor_;
};

TEST_F(Ft300Probe, SensorAnswersByModbus) {
  for (const bool is_tcp : {false, true}) {
    SensorOptions options;
    options.is_tcp = is_tcp;
    const std::string line = start(options);
    const Probe answer = probe(line, kBaud, 9, kPatience);
    EXPECT_EQ(answer.result, Result::kAnswers) << answer.what;
    EXPECT_EQ(answer.what,
              "force sensor on " + line +
                  " answers: FTS-2.0.1, measures (1.00, -2.00, -9.81) N before taring");
    EXPECT_FALSE(streams());
  }
}

TEST_F(Ft300Probe, StreamThatRunsIsHeardAndGoesOn) {
  const std::string line = start({});
  with_sensor([](Sensor& sensor, Time now) {
    const WriteRequest request{registers::kOutputSelect, {registers::kStartStream}};
    sensor.receive(encode_rtu(9, encode_pdu(request)), now);
  });
  ASSERT_TRUE(streams());
  const Probe answer = probe(line, kBaud, 9, kPatience);
  EXPECT_EQ(answer.result, Result::kAnswers);
  EXPECT_THAT(answer.what, HasSubstr("streams: (1.00, -2.00, -9.81) N"));
  EXPECT_TRUE(streams());
}

TEST_F(Ft300Probe, AnotherUnitAndAnotherModelAreNotTakenForIt) {
  SensorOptions options;
  options.unit = 10;
  const Probe silent = probe(start(options), kBaud, 9, 0.05);
  EXPECT_EQ(silent.result, Result::kSilent);
  EXPECT_THAT(silent.what, HasSubstr("the force sensor does not answer: /dev/pts/"));
  EXPECT_THAT(silent.mend, HasSubstr("unit 9 at 19200 bit/s"));
  SensorOptions gripper;
  gripper.model = "RGR";
  const Probe other = probe(start(gripper), kBaud, 9, kPatience);
  EXPECT_EQ(other.result, Result::kSilent);
  EXPECT_THAT(other.what, HasSubstr("'RGR-2.0.1', which is no FT 300"));
}

TEST_F(Ft300Probe, OtherBytesAreToldApartFromSilence) {
  PseudoTerminal line;
  std::atomic<bool> ends = false;
  std::thread others([&] {
    const std::uint8_t noise[] = {0x55, 0x42, 0x13};
    while (!ends) {
      line.write(noise, 1s);
      std::this_thread::sleep_for(1ms);
    }
  });
  const Probe answer = probe(line.name(), kBaud, 9, 0.05);
  ends = true;
  others.join();
  EXPECT_EQ(answer.result, Result::kSilent);
  EXPECT_THAT(answer.what, HasSubstr("what comes is not its stream"));
  EXPECT_THAT(answer.mend, HasSubstr("another bit rate"));
}

TEST_F(Ft300Probe, LineThatIsNotThereIsTheCallersMatter) {
  EXPECT_THROW(probe("/dev/no_sensor"), geometry::InputError);
  EXPECT_THROW(probe("tcp://127.0.0.1:1"), geometry::InputError);
}

}  // namespace
}  // namespace prehend::drivers::ft300
