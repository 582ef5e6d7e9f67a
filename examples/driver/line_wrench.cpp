// The node: the device's measurements on /wrench, as every wrist sensor of prehend has them, and
// its health.

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "drivers/wire/node/device_report.h"
#include "drivers/wire/stream/byte_stream.h"
#include "drivers/wire/stream/reopening.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node_program.h"
#include "wrench_line.h"

namespace {

using namespace prehend;
using std::chrono::steady_clock;

constexpr auto kTurn = std::chrono::milliseconds(20);  // how often it is looked whether to stop

struct Settings {
  std::string line, frame_id;
  int baud = 0;
  double stale_time = 0;  // s
};

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.line = node.declare_parameter<std::string>(
      {.name = "line",
       .default_value = "/dev/ttyUSB0",
       .description = "serial line of the sensor, or tcp://HOST:PORT",
       .read_only = true});
  s.baud = node.declare_parameter<int>({.name = "baud",
                                        .default_value = 115200,
                                        .unit = "bit/s",
                                        .minimum = 1200,
                                        .description = "of the line",
                                        .read_only = true});
  s.frame_id = node.declare_parameter<std::string>({.name = "frame_id",
                                                    .default_value = "gripper",
                                                    .description = "in which it measures",
                                                    .read_only = true});
  s.stale_time = node.declare_parameter<double>(
      {.name = "stale_time",
       .default_value = 0.2,
       .unit = "s",
       .minimum = 0.02,
       .maximum = 60,
       .description = "without a measurement, then the line is opened anew",
       .read_only = true});
  return s;
}

msgs::Wrench message_of(const my_driver::Measurement& measured, const std::string& frame_id,
                        std::int64_t stamp) {
  msgs::Wrench message;
  message.mutable_header()->set_stamp(stamp);
  message.mutable_header()->set_frame_id(frame_id);
  const auto set = [](msgs::Vector3* to, const std::array<double, 3>& from) {
    to->set_x(from[0]);
    to->set_y(from[1]);
    to->set_z(from[2]);
  };
  set(message.mutable_wrench()->mutable_force(), measured.force);
  set(message.mutable_wrench()->mutable_torque(), measured.torque);
  return message;
}

void run(graph::Node& node) {
  const Settings settings = declare_settings(node);
  const auto publisher = node.advertise<msgs::Wrench>("/wrench", graph::QoS::queue(10));
  node.spin_in_background();
  drivers::DeviceReport report(node);
  drivers::Reopening reopening(0.5, report.taker());
  std::unique_ptr<drivers::ByteStream> line;
  my_driver::LineDecoder decoder;
  auto heard = steady_clock::now();
  while (node.ok()) {
    if (!line) {
      line = reopening.attempt(
          [&] {
            return drivers::open_byte_stream(settings.line, static_cast<unsigned>(settings.baud));
          },
          kTurn);
      if (!line) {
        report.tell({drivers::Health::Level::kError, "no sensor: " + reopening.problem()});
        continue;
      }
      decoder = {};
      heard = steady_clock::now();
    }
    std::array<std::uint8_t, 4096> buffer{};
    const drivers::IoResult read = line->read(buffer, kTurn);
    const std::string_view bytes(reinterpret_cast<const char*>(buffer.data()), read.count);
    for (const my_driver::Measurement& measured : decoder.take(bytes)) {
      heard = steady_clock::now();
      publisher.publish(message_of(measured, settings.frame_id, node.clock().now()));
      report.tell({drivers::Health::Level::kOk, "measures"});
    }
    const std::chrono::duration<double> silence = steady_clock::now() - heard;
    const bool is_gone = read.status == drivers::IoStatus::kClosed;
    if (!is_gone && silence.count() < settings.stale_time) continue;
    // Nobody takes an old measurement for a new one: nothing is published until it speaks again.
    reopening.tell(is_gone ? read.problem : line->name() + " has said nothing for a while");
    report.tell({drivers::Health::Level::kError, reopening.problem()});
    line.reset();
  }
}

const graph::RegisteredNodeProgram registered({"line_wrench",
                                               "Publishes on /wrench what a force and torque "
                                               "sensor says, a line of text a measurement: fx fy "
                                               "fz tx ty tz, newtons and newton metres."},
                                              run);

}  // namespace
