// Many starts and ends, and two minutes of stream faster than real time.

#include <gtest/gtest.h>
#include <malloc.h>

#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <thread>

#include "drivers/ft300/driver/device.h"
#include "drivers/ft300/emulator/sensor.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "drivers/wire/stream/tcp_server.h"
#include "tests/drivers/eventually.h"

namespace prehend::drivers::ft300 {
namespace {

using namespace std::chrono_literals;

std::ptrdiff_t entries_of(const char* folder) {
  return std::distance(std::filesystem::directory_iterator(folder), {});
}

struct Holdings {
  std::ptrdiff_t files = entries_of("/proc/self/fd");
  std::ptrdiff_t threads = entries_of("/proc/self/task");
  std::size_t bytes = mallinfo2().uordblks;
};

// Devices that measure once and end.
void start_and_stop(const DeviceOptions& options, int cycles) {
  for (int i = 0; i < cycles; ++i) {
    std::atomic<bool> has_measured = false;
    Notes notes;
    const Device device(
        options, [&](const Measurement&) { has_measured = true; }, notes.taker());
    while (!has_measured) std::this_thread::yield();
  }
}

void expect_nothing_kept(const DeviceOptions& options, int cycles) {
  start_and_stop(options, 20);  // what is made once
  const Holdings before;
  start_and_stop(options, cycles);
  // The sensor's side, in this process too, notices a moment later that the last device has gone.
  EXPECT_TRUE(eventually([&] {
    const Holdings after;
    return after.files <= before.files && after.threads <= before.threads;
  })) << Holdings().files
      << " files, before " << before.files << "; " << Holdings().threads << " threads, before "
      << before.threads;
  EXPECT_LT(Holdings().bytes, before.bytes + 20000);
}

TEST(Ft300Endurance, TenThousandStartsAndEndsKeepNothing) {
  SensorOptions gateway;
  gateway.is_tcp = true;
  auto server = std::make_unique<TcpServer>();
  DeviceOptions options;
  options.line = server->name();
  options.rate = 10000;
  options.reply_time = 10;
  const ServedDevice<Sensor> sensor(gateway, std::move(server));
  expect_nothing_kept(options, 10000);
}

TEST(Ft300Endurance, StreamsThatAreStartedAndEndedKeepNothing) {
  auto terminal = std::make_unique<PseudoTerminal>();
  DeviceOptions options;
  options.line = terminal->name();
  options.reply_time = 10;
  options.stale_time = 10;
  options.silence = 0.005;
  options.rest = 1e-6;
  SensorOptions quick;
  quick.stream_rate = 1000;
  ServedDevice<Sensor> sensor(quick, std::move(terminal));
  expect_nothing_kept(options, 300);
  EXPECT_FALSE(sensor.with_device([](Sensor& s, Time) { return s.is_streaming(); }));
}

// A sensor in a time of its own, which runs as fast as the line takes its bytes.
TEST(Ft300Endurance, TwoMinutesOfStreamAccountForEveryMessage) {
  constexpr int kMessages = 120 * 100;
  constexpr auto kPatience = 60s;  // of a machine under load
  PseudoTerminal line;
  bool is_written = true;
  Sensor sensor({}, [&](Bytes bytes) {
    is_written = is_written && line.write(bytes, kPatience).status == IoStatus::kOk;
  });
  const auto numbered = [](int number) {
    return Measurement{{number % 30000 * 0.01, 0, -9.81}, {0, number / 30000 * 0.001, 0}};
  };
  std::atomic<int> received = 0, out_of_order = 0;
  Notes notes;
  DeviceOptions options;
  options.line = line.name();
  options.reply_time = options.stale_time = 60;
  Device device(
      options,
      [&](const Measurement& measurement) {
        const Measurement expected = numbered(received++);
        const bool is_next = std::abs(measurement.force[0] - expected.force[0]) < 1e-9 &&
                             std::abs(measurement.torque[1] - expected.torque[1]) < 1e-9;
        out_of_order += !is_next;
      },
      notes.taker());
  std::array<std::uint8_t, 256> buffer;
  Time now = 1s;
  for (int sent = 0; sent < kMessages && is_written;) {
    const IoResult heard = line.read(buffer, sensor.is_streaming() ? 0ns : Time(1ms));
    sensor.receive(Bytes(buffer).first(heard.count), now);
    sensor.set_measurement(numbered(sent));
    now += 10ms;
    sensor.update(now);
    sent = static_cast<int>(sensor.messages());
  }
  EXPECT_TRUE(is_written);
  EXPECT_TRUE(eventually([&] { return received == kMessages; }, kPatience)) << received;
  EXPECT_EQ(out_of_order, 0);
  EXPECT_EQ(device.statistics().measurements, static_cast<std::uint64_t>(kMessages));
  EXPECT_EQ(device.statistics().discarded, 0u);
  EXPECT_EQ(device.statistics().failures, 0u);
  // Its end asks for silence, which a sensor that nobody serves any more keeps.
}

}  // namespace
}  // namespace prehend::drivers::ft300
