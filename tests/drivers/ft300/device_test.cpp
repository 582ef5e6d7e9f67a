// The driver (libmodbus) against the emulated sensor (own codec) on a pseudo-terminal and over TCP.

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "drivers/ft300/driver/device.h"
#include "drivers/ft300/driver/tare.h"
#include "drivers/ft300/emulator/sensor.h"
#include "drivers/wire/faults/faulty_stream.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "drivers/wire/stream/tcp_server.h"
#include "tests/drivers/eventually.h"

namespace prehend::drivers::ft300 {
namespace {

using namespace std::chrono_literals;

const Measurement kWeight{{1.5, -2.25, -9.81}, {0.1, 0.02, -0.003}};

class Ft300 : public ::testing::Test {
 protected:
  void start(const SensorOptions& of_sensor, DeviceOptions options, bool faulty = false) {
    std::unique_ptr<ByteStream> end;
    if (of_sensor.is_tcp) {
      end = std::make_unique<TcpServer>();
    } else {
      auto terminal = std::make_unique<PseudoTerminal>(
          std::filesystem::temp_directory_path() / ("prehend_ft300_" + std::to_string(::getpid())));
      plug_ = terminal.get();
      end = std::move(terminal);
    }
    options.line = end->name();
    options.retry = 0.02;
    if (faulty) {
      auto stream = std::make_unique<FaultyStream>(std::move(end));
      faults_ = stream.get();
      end = std::move(stream);
    }
    sensor_ = std::make_unique<ServedDevice<Sensor>>(of_sensor, std::move(end));
    sensor_->with_device([](Sensor& sensor, Time) { sensor.set_measurement(kWeight); });
    device_ = std::make_unique<Device>(
        options,
        [this](const Measurement& measurement) {
          ++count_;
          wrong_ += measurement != kWeight;
        },
        notes_.taker());
  }
  bool measures(int count = 20) {
    const int before = count_;
    return eventually([&] { return count_ > before + count; });
  }
  template <class Work>
  auto with_sensor(Work&& work) {
    return sensor_->with_device([&](Sensor& sensor, Time now) { return work(sensor, now); });
  }

  PseudoTerminal* plug_ = nullptr;
  FaultyStream* faults_ = nullptr;
  Notes notes_;
  std::atomic<int> count_ = 0, wrong_ = 0;
  std::unique_ptr<ServedDevice<Sensor>> sensor_;
  std::unique_ptr<Device> device_;
};

TEST_F(Ft300, StreamsOnASerialLineAndEndsTheStream) {
  start({}, {});
  ASSERT_TRUE(measures(200));
  EXPECT_EQ(wrong_, 0);
  EXPECT_EQ(device_->firmware(), "FTS-2.0.1");
  EXPECT_EQ(device_->state(), DeviceState::kMeasuring);
  EXPECT_GT(device_->statistics().rate, 0);  // 100 on an idle machine
  EXPECT_EQ(device_->statistics().discarded, 0u);
  device_.reset();
  EXPECT_FALSE(with_sensor([](Sensor& sensor, Time) { return sensor.is_streaming(); }));
}

TEST_F(Ft300, PollsRegisters) {
  DeviceOptions options;
  options.stream = false;
  start({}, options);
  ASSERT_TRUE(measures(50));
  EXPECT_EQ(wrong_, 0);
  EXPECT_FALSE(with_sensor([](Sensor& sensor, Time) { return sensor.is_streaming(); }));
}

TEST_F(Ft300, PollsThroughATcpGateway) {
  SensorOptions tcp;
  tcp.is_tcp = true;
  start(tcp, {});
  ASSERT_TRUE(measures(50));
  EXPECT_EQ(wrong_, 0);
}

TEST_F(Ft300, StreamLeftOnByAnEarlierClientIsStoppedFirst) {
  start({}, {});
  ASSERT_TRUE(measures(5));
  // A second one on the same line, as after a crash of the first.
  device_.reset();
  with_sensor([](Sensor& sensor, Time now) {
    const auto request = encode_rtu(
        9, encode_pdu(WriteRequest{registers::kOutputSelect, {registers::kStartStream}}));
    sensor.receive(request, now);
    return 0;
  });
  DeviceOptions options;
  options.line = plug_->name();
  Device second(
      options, [this](const Measurement&) { ++count_; }, notes_.taker());
  EXPECT_TRUE(measures());
}

TEST_F(Ft300, AnotherUnitOrAnotherDeviceIsNotTakenForIt) {
  SensorOptions other;
  other.unit = 10;
  start(other, {});
  ASSERT_TRUE(eventually([&] { return notes_.has("registers from 500 on cannot be read"); }));
  device_.reset();
  sensor_.reset();
  SensorOptions gripper;
  gripper.model = "RGR";
  start(gripper, {});
  ASSERT_TRUE(eventually([&] { return notes_.has("'RGR-2.0.1', which is no FT 300"); }));
  EXPECT_EQ(count_, 0);
}

TEST_F(Ft300, SilenceIsReportedAndItComesBack) {
  start({}, {});
  ASSERT_TRUE(measures());
  with_sensor([](Sensor& sensor, Time) { sensor.set_silent(true); });
  ASSERT_TRUE(eventually([&] { return notes_.has("no measurement for"); }));
  EXPECT_NE(device_->state(), DeviceState::kMeasuring);
  with_sensor([](Sensor& sensor, Time) { sensor.set_silent(false); });
  EXPECT_TRUE(measures());
}

TEST_F(Ft300, UnpluggedAndPluggedAgain) {
  start({}, {});
  ASSERT_TRUE(measures());
  plug_->unplug();
  ASSERT_TRUE(eventually([&] { return device_->state() == DeviceState::kDisconnected; }));
  ASSERT_TRUE(eventually([&] { return notes_.has("cannot open"); }));
  plug_->plug();
  EXPECT_TRUE(measures());
}

TEST_F(Ft300, RestartOfTheSensorIsSurvived) {
  start({}, {});
  ASSERT_TRUE(measures());
  with_sensor([](Sensor& sensor, Time now) { sensor.reboot(now); });
  EXPECT_TRUE(measures(60));
}

TEST_F(Ft300, DamageGivesNoWrongMeasurement) {
  for (const bool stream : {true, false}) {
    count_ = 0;
    DeviceOptions options;
    options.stream = stream;
    options.reply_time = 0.02;
    start({}, options, true);
    ASSERT_TRUE(measures());
    faults_->set_faults({.dropped = 0.1, .corrupted = 0.1, .late = 0.1, .delay = 10ms});
    EXPECT_TRUE(measures(100));
    EXPECT_EQ(wrong_, 0);
    const Statistics statistics = device_->statistics();
    EXPECT_GT(statistics.discarded + statistics.failures, 0u);
    device_.reset();
    sensor_.reset();
  }
}

TEST(Ft300Tare, SubtractsTheMean) {
  Tare tare;
  EXPECT_FALSE(tare.is_set());
  EXPECT_EQ(tare.apply(kWeight), kWeight);
  EXPECT_FALSE(tare.add(kWeight));
  tare.begin(2);
  EXPECT_FALSE(tare.add({{1, 0, 0}, {0, 0, 0.1}}));
  EXPECT_TRUE(tare.is_collecting());
  EXPECT_TRUE(tare.add({{3, 0, 0}, {0, 0, 0.3}}));
  EXPECT_TRUE(tare.is_set());
  const Measurement applied = tare.apply({{2, 1, 0}, {0, 0, 0.2}});
  EXPECT_NEAR(applied.force[0], 0, 1e-12);
  EXPECT_NEAR(applied.force[1], 1, 1e-12);
  EXPECT_NEAR(applied.torque[2], 0, 1e-12);
}

TEST(Ft300Device, OptionsThatMakeNoSenseAreRefused) {
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    DeviceOptions options;
    options.rate = bad;
    EXPECT_THROW(Device(
                     options, [](const Measurement&) {}, [](bool, const std::string&) {}),
                 std::invalid_argument);
  }
}

}  // namespace
}  // namespace prehend::drivers::ft300
