// The three drivers' nodes as processes, at full rate against emulated devices: processor time, and
// the way from the wire to a subscriber in another process.

#include <benchmark/benchmark.h>
#include <fcntl.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "bench/drivers/node_under_load.h"
#include "drivers/dsa/emulator/controller.h"
#include "drivers/ft300/emulator/sensor.h"
#include "drivers/pg70/emulator/served_module.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace std::chrono_literals;

/// Times of what a device put on its line and what a subscriber got, matched by their content: each
/// message carries a number of its own.
class Latencies {
 public:
  /// `parts`: writes of which a message consists, e.g. three CAN frames.
  explicit Latencies(int parts) : parts_(parts) {}
  void left_device(int number, Time now) {
    const std::lock_guard lock(mutex_);
    ++left_count_;
    left_.emplace_back(number, now);
    if (left_.size() > 1000) left_.pop_front();
  }
  void arrived(int number, Time now) {
    const std::lock_guard lock(mutex_);
    for (auto it = left_.rbegin(); it != left_.rend(); ++it) {
      if (it->first != number) continue;
      seconds_.push_back(to_seconds(now - it->second));
      return;
    }
  }
  std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return seconds_.size();
  }
  void clear() {
    const std::lock_guard lock(mutex_);
    seconds_.clear();
    left_count_ = 0;
  }
  /// Messages that left and did not arrive; one may be on its way.
  double missing() const {
    const std::lock_guard lock(mutex_);
    return static_cast<double>(left_count_) / parts_ - static_cast<double>(seconds_.size());
  }
  /// [µs]
  double quantile(double q) const {
    const std::lock_guard lock(mutex_);
    if (seconds_.empty()) return std::nan("");
    std::vector<double> sorted = seconds_;
    std::sort(sorted.begin(), sorted.end());
    return 1e6 * sorted[std::min(sorted.size() - 1,
                                 static_cast<std::size_t>(q * static_cast<double>(sorted.size())))];
  }

 private:
  int parts_;
  mutable std::mutex mutex_;
  std::deque<std::pair<int, Time>> left_;
  std::vector<double> seconds_;
  std::size_t left_count_ = 0;
};

/// Notes when a write of the emulated device is done, i.e. the whole message is on the line.
class TimedStream : public ByteStream {
 public:
  TimedStream(std::unique_ptr<ByteStream> stream, std::function<void(Bytes)> before)
      : stream_(std::move(stream)), before_(std::move(before)) {}
  IoResult read(std::span<std::uint8_t> buffer, std::chrono::nanoseconds timeout) override {
    return stream_->read(buffer, timeout);
  }
  IoResult write(Bytes bytes, std::chrono::nanoseconds timeout) override {
    before_(bytes);
    return stream_->write(bytes, timeout);
  }
  const std::string& name() const override { return stream_->name(); }

 private:
  std::unique_ptr<ByteStream> stream_;
  std::function<void(Bytes)> before_;
};

/// A plant whose opening counts up, so that each state tells itself apart.
class CountingGripper : public pg70::GripperPlant {
 public:
  void command(const Command&) override {}
  Motion advance(double seconds) override {
    number_ = (number_ + (seconds > 0 ? 1 : 0)) % 60000;
    return {number_ * 1e-6, 0, 0};
  }
  int number() const { return number_; }

 private:
  int number_ = 0;
};

std::string file_name(const char* what) {
  return "/tmp/prehend_bench_" + std::to_string(::getpid()) + "_" + what;
}

void add(benchmark::State& state, const char* name, const Latencies& latencies) {
  state.counters[std::string(name) + "_p50_us"] = latencies.quantile(0.5);
  state.counters[std::string(name) + "_p99_us"] = latencies.quantile(0.99);
}

void three_drivers_at_full_rate(benchmark::State& state) {
  const auto seconds = static_cast<double>(state.range(0));
  graph::Registry registry({.endpoint = "tcp://127.0.0.1:*"});
  Latencies gripper(3), touch(1), force(1);

  CountingGripper plant;
  auto can = std::make_unique<TimedStream>(
      std::make_unique<PseudoTerminal>(file_name("can")),
      [&](Bytes) { gripper.left_device(plant.number(), steady_now()); });
  pg70::ServedModule module(
      plant, {},
      pg70::make_can_link(std::make_unique<Slcan>(std::move(can), 0, std::vector<std::uint16_t>{}),
                          12, pg70::Side::kModule));

  dsa::ControllerOptions six;
  for (int i = 0; i < 4; ++i) six.matrices.push_back({6, 13, 3.4});
  ServedDevice<dsa::Controller> controller(
      six, std::make_unique<TimedStream>(
               std::make_unique<PseudoTerminal>(file_name("dsa")), [&](Bytes bytes) {
                 dsa::PacketDecoder decoder;
                 decoder.add(bytes);
                 dsa::Frame frame;
                 const auto packet = decoder.next();
                 if (!packet || !dsa::decode_frame(packet->payload, 480, frame)) return;
                 touch.left_device(frame.texels[0], steady_now());
               }));
  ServedDevice<ft300::Sensor> sensor(
      ft300::SensorOptions{},
      std::make_unique<TimedStream>(
          std::make_unique<PseudoTerminal>(file_name("ft300")), [&](Bytes bytes) {
            ft300::StreamDecoder decoder;
            decoder.add(bytes);
            const auto measurement = decoder.next();
            if (!measurement) return;
            force.left_device(static_cast<int>(std::lround(measurement->force[0] * 100)),
                              steady_now());
          }));
  // New content all the time: the next number is set before the next message is encoded.
  std::atomic<bool> ends = false;
  std::thread world([&] {
    std::vector<std::uint16_t> texels(480);
    for (int i = 0; !ends; ++i) {
      const int number = i % 4096;
      controller.with_device([&](dsa::Controller& c, Time) {
        for (std::size_t k = 0; k < 40; ++k) texels[60 + k] = static_cast<std::uint16_t>(97 * k);
        texels[0] = static_cast<std::uint16_t>(number);
        c.set_texels(texels);
      });
      sensor.with_device([&](ft300::Sensor& s, Time) {
        s.set_measurement({{number * 0.01, 0, 0}, {}});
      });
      std::this_thread::sleep_for(3ms);
    }
  });

  graph::NodeOptions options;
  options.name = "bench";
  options.registry = registry.endpoint();
  graph::Node node(options);
  const auto states = node.subscribe<msgs::GripperState>(
      "/gripper/state", graph::QoS::queue(100), [&](const auto& m) {
        gripper.arrived(static_cast<int>(std::lround(m->opening() * 1e6)), steady_now());
      });
  const auto frames = node.subscribe<msgs::TactileFrame>(
      "/tactile/a", graph::QoS::queue(100),
      [&](const auto& m) { touch.arrived(static_cast<int>(m->intensity(0)), steady_now()); });
  const auto wrenches =
      node.subscribe<msgs::Wrench>("/wrench", graph::QoS::queue(100), [&](const auto& m) {
        force.arrived(static_cast<int>(std::lround(m->wrench().force().x() * 100)), steady_now());
      });
  node.spin_in_background();
  const auto parameters = [&](std::vector<std::string> words) {
    std::vector<std::string> arguments{"--registry", registry.endpoint(), "--log-level", "error"};
    for (std::string& word : words) {
      arguments.push_back("--param");
      arguments.push_back(std::move(word));
    }
    return arguments;
  };
  for (auto _ : state) {
    const bench::NodeProcess processes[] = {
        {"pg70", parameters({"can:=slcan:" + file_name("can")})},
        {"dsa", parameters({"line:=" + file_name("dsa"), "pads:=[a, b, c, d, e, f]",
                            "matrices:=[0, 1, 2, 3, 4, 5]"})},
        {"ft300", parameters({"line:=" + file_name("ft300"), "tare_at_start:=false"})}};
    const Time give_up = steady_now() + 30s;
    while ((gripper.count() < 10 || force.count() < 10) && steady_now() < give_up) {
      std::this_thread::sleep_for(20ms);
    }
    std::this_thread::sleep_for(1s);
    for (Latencies* latencies : {&gripper, &touch, &force}) latencies->clear();
    const char* const names[] = {"pg70", "dsa", "ft300"};
    double before[3], used = 0;
    for (int i = 0; i < 3; ++i) before[i] = processes[i].processor_time();
    const Time begin = steady_now();
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    const double time = to_seconds(steady_now() - begin);
    for (int i = 0; i < 3; ++i) {
      const double percent = 100 * (processes[i].processor_time() - before[i]) / time;
      state.counters[std::string(names[i]) + "_processor_percent"] = percent;
      used += percent;
    }
    state.SetIterationTime(time);
    state.counters["processor_percent"] = used;
    state.counters["gripper_missing"] = gripper.missing();
    state.counters["touch_missing"] = touch.missing();
    state.counters["force_missing"] = force.missing();
    state.counters["gripper_hz"] = static_cast<double>(gripper.count()) / time;
    state.counters["touch_hz"] = static_cast<double>(touch.count()) / time;
    state.counters["force_hz"] = static_cast<double>(force.count()) / time;
  }
  add(state, "gripper", gripper);
  add(state, "touch", touch);
  add(state, "force", force);
  ends = true;
  world.join();
}
BENCHMARK(three_drivers_at_full_rate)
    ->ArgName("seconds")
    ->Arg(10)
    ->Arg(120)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kSecond);

}  // namespace
