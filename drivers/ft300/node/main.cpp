#include <mutex>
#include <string>
#include <vector>

#include "drivers/ft300/driver/device.h"
#include "drivers/ft300/driver/tare.h"
#include "drivers/ft300/node/mounting.h"
#include "drivers/wire/health/link_quality.h"
#include "drivers/wire/node/device_report.h"
#include "drivers/wire/node/wall_timer.h"
#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::ft300;

struct Settings {
  DeviceOptions device;
  std::string frame_id;
  geometry::RigidTransform X_GS = geometry::RigidTransform::Identity();
  bool inverted = false;
  bool tare_at_start = true;
  int tare_count = 50;
};

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.device.line = node.declare_parameter<std::string>(
      {.name = "line",
       .default_value = "/dev/ttyUSB1",
       .description = "serial line of the sensor, or tcp://HOST:PORT of a Modbus gateway",
       .read_only = true});
  s.device.unit =
      static_cast<std::uint8_t>(node.declare_parameter<int>({.name = "unit",
                                                             .default_value = 9,
                                                             .minimum = 1,
                                                             .maximum = 247,
                                                             .description = "Modbus address",
                                                             .read_only = true}));
  s.device.baud = static_cast<unsigned>(node.declare_parameter<int>({.name = "baud",
                                                                     .default_value = 19200,
                                                                     .unit = "bit/s",
                                                                     .minimum = 1200,
                                                                     .description = "of the line",
                                                                     .read_only = true}));
  s.device.stream = node.declare_parameter<bool>(
      {.name = "stream",
       .default_value = true,
       .description = "100 measurements a second; else registers are polled, as always over TCP",
       .read_only = true});
  s.device.rate = node.declare_parameter<double>({.name = "rate",
                                                  .default_value = 100.0,
                                                  .unit = "1/s",
                                                  .minimum = 0.1,
                                                  .maximum = 1000,
                                                  .description = "of polling, at most",
                                                  .read_only = true});
  s.device.stale_time = node.declare_parameter<double>(
      {.name = "stale_time",
       .default_value = s.device.stale_time,
       .unit = "s",
       .minimum = 0.02,
       .maximum = 60,
       .description = "without a measurement, then it is reported and begun anew",
       .read_only = true});
  s.frame_id =
      node.declare_parameter<std::string>({.name = "frame_id",
                                           .default_value = "gripper",
                                           .description = "in which the wrench is published",
                                           .read_only = true});
  s.X_GS = mounting_from(node.declare_parameter<std::vector<double>>(
      {.name = "mounting",
       .default_value = {0, 0, 0, 0, 0, 0},
       .description = "pose of the sensor in that frame: x y z [m] roll pitch yaw [rad]",
       .read_only = true}));
  s.inverted = node.declare_parameter<bool>(
      {.name = "inverted",
       .default_value = false,
       .description = "the sensor shows what the gripper exerts on the world",
       .read_only = true});
  s.tare_at_start = node.declare_parameter<bool>(
      {.name = "tare_at_start",
       .default_value = true,
       .description = "the first measurements become zero; nothing may touch the gripper then",
       .read_only = true});
  s.tare_count =
      node.declare_parameter<int>({.name = "tare_count",
                                   .default_value = 50,
                                   .minimum = 1,
                                   .maximum = 10000,
                                   .description = "measurements that zero is the mean of",
                                   .read_only = true});
  return s;
}

msgs::Wrench wrench_message(const Measurement& wrench, const std::string& frame_id,
                            std::int64_t stamp, bool biased) {
  msgs::Wrench message;
  message.mutable_header()->set_stamp(stamp);
  message.mutable_header()->set_frame_id(frame_id);
  const auto set = [](msgs::Vector3* to, const std::array<double, 3>& from) {
    to->set_x(from[0]);
    to->set_y(from[1]);
    to->set_z(from[2]);
  };
  set(message.mutable_wrench()->mutable_force(), wrench.force);
  set(message.mutable_wrench()->mutable_torque(), wrench.torque);
  message.set_biased(biased);
  return message;
}

/// Health and counters, looked at in real time.
class Watcher {
 public:
  Watcher(graph::Node& node, const Device& device, double stream_rate)
      : node_(node),
        device_(device),
        stream_rate_(stream_rate),
        report_(node),
        publisher_(node.advertise<msgs::DeviceStatus>("/wrench/device", graph::QoS::latched(1))),
        timer_(kPeriod, [this] { look(); }) {}

 private:
  static constexpr double kPeriod = 0.1;            // s
  static constexpr int kSample = 5, kPublish = 10;  // periods

  void look() {
    const DeviceState state = device_.state();
    const Statistics s = device_.statistics();
    const std::uint64_t damaged = (s.discarded + kStreamMessageSize - 1) / kStreamMessageSize;
    if (state != DeviceState::kMeasuring) {
      quality_.restart();  // what is lost while it is away is no fault of the line
    } else if (looks_ % kSample == 0) {
      quality_.sample(s.measurements, damaged + s.failures, stream_rate_, steady_now());
    }
    report_.tell(health(state));
    if (looks_++ % kPublish != 0) return;
    msgs::DeviceStatus status;
    status.mutable_header()->set_stamp(node_.clock().now());
    status.set_state(to_string(state));
    status.set_messages(s.measurements);
    status.set_damaged(damaged);
    status.set_unanswered(s.failures);
    status.set_connections(s.connections);
    status.set_rate(quality_.rate());
    status.set_damaged_part(quality_.harmed_part());
    publisher_.publish(status);
  }
  Health health(DeviceState state) const {
    const std::string trouble = device_.trouble();
    if (!trouble.empty()) return {Health::Level::kError, trouble};
    return with_warning({Health::Level::kOk, to_string(state)}, quality_.problem());
  }

  graph::Node& node_;
  const Device& device_;
  double stream_rate_;  // 1/s, 0: it is polled
  DeviceReport report_;
  LinkQuality quality_;
  int looks_ = 0;
  graph::Publisher<msgs::DeviceStatus> publisher_;
  WallTimer timer_;
};

void run(graph::Node& node) {
  const Settings settings = declare_settings(node);
  DeviceReport report(node);
  const auto publisher = node.advertise<msgs::Wrench>("/wrench", graph::QoS::queue(100));
  std::mutex mutex;  // guards tare
  Tare tare;
  if (settings.tare_at_start) tare.begin(settings.tare_count);
  Device device(
      settings.device,
      [&](const Measurement& measurement) {
        Measurement zeroed;
        bool biased = false, is_done = false;
        {
          const std::lock_guard lock(mutex);
          is_done = tare.add(measurement);
          zeroed = tare.apply(measurement);
          biased = tare.is_set();
        }
        if (is_done) node.log_info("tared");
        publisher.publish(wrench_message(in_gripper_frame(zeroed, settings.X_GS, settings.inverted),
                                         settings.frame_id, node.clock().now(), biased));
      },
      report.taker());
  const graph::Service tare_service =
      node.serve<msgs::Empty, msgs::Acknowledge>("/wrench/tare", [&](const msgs::Empty&) {
        msgs::Acknowledge answer;
        answer.set_success(device.state() == DeviceState::kMeasuring);
        if (!answer.success()) {
          answer.set_reason("the sensor does not measure now");
          return answer;
        }
        const std::lock_guard lock(mutex);
        tare.begin(settings.tare_count);
        answer.set_reason(
            fmt::format("the mean of the next {} measurements becomes zero", settings.tare_count));
        return answer;
      });
  constexpr double kStreamRate = 100;  // 1/s, the sensor's
  const bool streams = settings.device.stream && !settings.device.line.starts_with("tcp://");
  const Watcher watcher(node, device, streams ? kStreamRate : 0);
  node.spin();
}

const graph::RegisteredNodeProgram registered(
    {"ft300",
     "Reads a Robotiq FT 300 force sensor by Modbus RTU, its stream, or a Modbus TCP gateway, and "
     "publishes /wrench as the simulated wrist does: what the world exerts on the gripper, tared. "
     "The service /wrench/tare makes the present wrench zero; /wrench/device tells how good the "
     "line is."},
    run);

}  // namespace
