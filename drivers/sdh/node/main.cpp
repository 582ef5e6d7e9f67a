#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "drivers/sdh/driver/device.h"
#include "drivers/sdh/driver/health.h"
#include "drivers/sdh/driver/probe.h"
#include "drivers/sdh/node/hand_axes.h"
#include "drivers/sdh/node/hand_guard.h"
#include "drivers/wire/guardian/guarded.h"
#include "drivers/wire/hand/hand_offers.h"
#include "drivers/wire/health/link_quality.h"
#include "drivers/wire/node/device_report.h"
#include "drivers/wire/node/joint_report.h"
#include "drivers/wire/node/wall_timer.h"
#include "msgs/hand.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/platform_source/platform_source.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::sdh;

constexpr double kRetry = 0.5;  // s between tries to open the line

struct Settings {
  std::string line;
  unsigned baud = kBaud;
  DriverOptions driver;
  bool guardian = true;
  double guardian_time = Guardian::kPatience;  // s
  std::string platform, platforms;
  std::vector<std::string> axes;
  double most_current = 1;  // A
  std::string other_joints;
};

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.line = node.declare_parameter<std::string>(
      {.name = "line",
       .default_value = "/dev/ttyUSB0",
       .description = "serial line of the hand, or tcp://HOST:PORT (port 23; firmware 0.0.3.1 and "
                      "later)",
       .read_only = true});
  s.baud = static_cast<unsigned>(node.declare_parameter<int>({.name = "baud",
                                                              .default_value = kBaud,
                                                              .unit = "bit/s",
                                                              .minimum = 1200,
                                                              .description = "of the serial line",
                                                              .read_only = true}));
  s.platform = node.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "kr5_sdh",
       .description = "whose hand it is: joints, limits of position, speed and effort",
       .read_only = true});
  s.platforms = nodes::declare_platforms(node);
  s.axes = node.declare_parameter<std::vector<std::string>>(
      {.name = "axes",
       .default_value = kSdh2Axes,
       .description = "the hand's joints in the order of the device's axes 0 to 6",
       .read_only = true});
  s.most_current = node.declare_parameter<double>(
      {.name = "most_current",
       .default_value = s.most_current,
       .unit = "A",
       .minimum = 0.01,
       .maximum = 1,
       .description = "greatest current limit of a motor; thought to give its joint's greatest "
                      "effort, so that efforts become current limits in proportion",
       .read_only = true});
  s.other_joints = node.declare_parameter<std::string>(
      {.name = "other_joints",
       .default_value = "",
       .description = "topic whose joints, those of the arm, are told with the hand's on "
                      "/joint_states; empty: none",
       .read_only = true});
  s.driver.profile = node.declare_parameter<std::string>(
                         {.name = "profile",
                          .default_value = "ramp",
                          .choices = {"ramp", "sine_square"},
                          .description = "velocity profile of motions; targets may change on the "
                                         "way of a ramp alone",
                          .read_only = true}) == "ramp"
                         ? Profile::kRamp
                         : Profile::kSineSquare;
  s.driver.acceleration = node.declare_parameter<double>({.name = "acceleration",
                                                          .default_value = s.driver.acceleration,
                                                          .unit = "rad/s^2",
                                                          .minimum = 0.1,
                                                          .maximum = 6.9,
                                                          .description = "of the ramp",
                                                          .read_only = true});
  s.driver.binary = node.declare_parameter<bool>(
      {.name = "binary",
       .default_value = s.driver.binary,
       .description = "values of axes go in the checked binary form, where the firmware has it "
                      "(0.0.2.15 and later); false: as text",
       .read_only = true});
  const auto seconds = [&](const char* name, double value, double least, const char* words) {
    return node.declare_parameter<double>({.name = name,
                                           .default_value = value,
                                           .unit = "s",
                                           .minimum = least,
                                           .maximum = 10,
                                           .description = words,
                                           .read_only = true});
  };
  s.driver.state_period =
      seconds("state_period", s.driver.state_period, 0.01, "between rounds of readings");
  s.driver.watchdog =
      seconds("watchdog", s.driver.watchdog, 0.01,
              "without a command while moving by /hand/command, then it is stopped");
  s.driver.loss_time =
      seconds("loss_time", s.driver.loss_time, 0.1, "without a state, then it is stopped");
  s.driver.reply_time =
      seconds("reply_time", s.driver.reply_time, 0.02, "to wait for an answer before trying again");
  s.driver.blocked_time = seconds("blocked_time", s.driver.blocked_time, 0.02,
                                  "of standing before its target that count as blocked");
  s.driver.start_time = seconds("start_time", s.driver.start_time, 0.02,
                                "that the hand's states may take to show a motion");
  s.driver.stop_time = seconds("stop_time", s.driver.stop_time, 0.1,
                               "of motion after a stop was answered, then axes are switched off");
  s.driver.stretch =
      seconds("stretch", s.driver.stretch, 0.1,
              "that a speed of /hand/command goes on by itself when line or driver die");
  s.guardian = node.declare_parameter<bool>(
      {.name = "guardian",
       .default_value = s.guardian,
       .description = "a process of its own stops the hand when this one dies or hangs",
       .read_only = true});
  s.guardian_time = seconds("guardian_time", s.guardian_time, 0.1,
                            "without progress of this process while the hand moves, then its "
                            "guardian stops it");
  s.driver.hot = node.declare_parameter<double>(
      {.name = "hot",
       .default_value = s.driver.hot,
       .unit = "degC",
       .minimum = 30,
       .maximum = 120,
       .description = "temperature from which on it is told; where the hand stops answering is not "
                      "published",
       .read_only = true});
  s.driver.power_off_at_end = node.declare_parameter<bool>(
      {.name = "power_off_at_end",
       .default_value = s.driver.power_off_at_end,
       .description = "when the driver ends, axes are switched off unless they hold something",
       .read_only = true});
  s.driver.has_checksum = !s.line.starts_with("tcp://");
  return s;
}

const char* words_of(AxisState state) {
  constexpr const char* kWords[kLastAxisState + 1] = {"idle",
                                                      "positioning",
                                                      "speed",
                                                      "not initialised",
                                                      "blocked clockwise",
                                                      "blocked counter-clockwise",
                                                      "off",
                                                      "limit reached"};
  return kWords[std::min<std::size_t>(static_cast<std::size_t>(state), kLastAxisState)];
}

/// Health, counters and temperatures, looked at in real time.
class Watcher {
 public:
  Watcher(graph::Node& node, const Settings& settings, Device& device, const JointReport& joints,
          const Guarded& guarded, const HandOffers& offers, nodes::EmergencyStopListener& emergency)
      : settings_(settings),
        device_(device),
        guarded_(guarded),
        offers_(offers),
        emergency_(emergency),
        joints_(joints),
        node_(node),
        report_(node),
        publisher_(node.advertise<msgs::DeviceStatus>("/hand/device", graph::QoS::latched(1))),
        status_(node.advertise<msgs::HandStatus>("/hand/status", graph::QoS::latched(1))),
        timer_(kPeriod, [this] { look(); }) {}

 private:
  static constexpr double kPeriod = 0.1;            // s
  static constexpr int kSample = 5, kPublish = 10;  // periods

  void look() {
    Situation situation;
    situation.line = settings_.line;
    situation.hot = settings_.driver.hot;
    DriverCounters counters;
    std::uint64_t damaged = 0;
    device_.with_driver([&](Driver& driver, Time) {
      situation.reading = driver.reading();
      counters = driver.counters();
      damaged = driver.damaged() + counters.strange;
    });
    const Reading& reading = situation.reading;
    connecting_ = reading.state == DriverState::kConnecting ? connecting_ + kPeriod : 0;
    situation.line_problem = device_.line_problem();
    situation.connecting = connecting_;
    if (reading.state <= DriverState::kLost) {
      quality_.restart();  // what is lost while nobody answers is no fault of the line
    } else if (looks_ % kSample == 0) {
      quality_.sample(counters.replies, damaged + counters.unanswered, 0, steady_now());
    }
    situation.link_problem = quality_.problem();
    situation.guard_problem = guarded_.problem();
    emergency_.tell_device(stopped_by_itself(reading));
    Health health = health_of(situation);
    // At a start the others may come a little later.
    const std::string of_others = joints_.problem();
    lonely_ = of_others.empty() ? 0 : lonely_ + kPeriod;
    if (reading.state > DriverState::kLost && lonely_ > 1) health = with_warning(health, of_others);
    report_.tell(health);
    if (looks_++ % kPublish != 0) return;
    msgs::DeviceStatus status;
    status.mutable_header()->set_stamp(node_.clock().now());
    status.set_state(to_string(reading.state));
    status.set_error_code(reading.error_code);
    status.set_messages(counters.replies);
    status.set_damaged(damaged);
    status.set_unanswered(counters.unanswered);
    status.set_connections(counters.connections);
    status.set_rate(quality_.rate());
    status.set_damaged_part(quality_.harmed_part());
    publisher_.publish(status);
    if (reading.states > 0) tell(reading);
  }
  // Axes that went off are told once: what is stopped for it cannot switch them on again.
  std::string stopped_by_itself(const Reading& reading) {
    was_ready_ = was_ready_ || reading.state >= DriverState::kOff;
    const bool was_on = std::exchange(
        is_on_, reading.state > DriverState::kOff || (is_on_ && reading.state < DriverState::kOff));
    if (was_on && reading.state == DriverState::kOff && !offers_.is_switched_off()) {
      return "the hand's axes went off, and nobody had asked for it";
    }
    return was_ready_ ? own_stop(reading) : std::string();
  }
  void tell(const Reading& reading) {
    msgs::HandStatus status;
    status.mutable_header()->set_stamp(node_.clock().now());
    status.set_firmware(reading.firmware);
    for (std::size_t i = 0; i < kAxes; ++i) {
      status.add_name(settings_.axes[i]);
      status.add_axis_state(words_of(reading.axes[i]));
      status.add_blocked(reading.blocked[i]);
    }
    // Old firmware tells the boards' alone.
    const std::size_t motors = reading.temperatures.size() >= kAxes ? kAxes : 0;
    for (std::size_t i = 0; i < reading.temperatures.size(); ++i) {
      if (i < motors) {
        status.add_temperature(reading.temperatures[i]);
      } else {
        status.add_electronics(reading.temperatures[i]);
      }
    }
    status_.publish(status);
  }

  const Settings& settings_;
  Device& device_;
  const Guarded& guarded_;
  const HandOffers& offers_;
  nodes::EmergencyStopListener& emergency_;
  const JointReport& joints_;
  graph::Node& node_;
  DeviceReport report_;
  LinkQuality quality_;
  double connecting_ = 0;  // s
  double lonely_ = 0;      // s without the others' joints
  bool was_ready_ = false, is_on_ = false;
  int looks_ = 0;
  graph::Publisher<msgs::DeviceStatus> publisher_;
  graph::Publisher<msgs::HandStatus> status_;
  WallTimer timer_;
};

void run(graph::Node& node) {
  Settings settings = declare_settings(node);
  // --help and --describe end here, before anything is read or opened.
  auto joint_publisher = node.advertise<msgs::JointState>("/joint_states", graph::QoS::queue(100));
  const HandAxes axes =
      hand_axes(robot::read_platform(robot::platform_file(settings.platforms, settings.platform)),
                settings.axes, settings.most_current);
  settings.driver.limits = axes.limits<kAxes>();
  DeviceReport report(node);
  JointReport joints(node, axes.moving_names(), settings.other_joints, std::move(joint_publisher));
  // Begins before the device, so that it lives on until the device has stopped the hand.
  const auto guarded =
      settings.guardian ? std::make_unique<Guarded>(guardian_program(settings.line, settings.baud),
                                                    settings.guardian_time, report.taker())
                        : std::make_unique<Guarded>();
  Device device(
      settings.driver, [&] { return open_byte_stream(settings.line, settings.baud); },
      [&](const Reading& reading) {
        if (reading.state <= DriverState::kLost) return;
        joints.tell(axes.moving_values(reading.position), axes.moving_rates(reading.velocity));
      },
      report.taker(), kRetry,
      [&](const Reading& reading) -> std::string {
        if (!guarded->progress(watch_of(reading))) return {};
        return "this driver made no progress, so its guardian stopped the hand";
      });
  nodes::EmergencyStopListener emergency(node);
  OfferedDevice<Device, kAxes> offered(device, emergency);
  const HandOffers offers(node, offered, axes, emergency, true);
  const Watcher watcher(node, settings, device, joints, *guarded, offers, emergency);
  node.spin();
}

const graph::RegisteredNodeProgram registered(
    {"sdh",
     "Drives a Schunk SDH-2 hand over RS-232 or TCP. Offers what the simulated hand offers: "
     "publishes "
     "its joints on /joint_states, takes the action /hand/move, the topic /hand/command (POSITION "
     "and VELOCITY; stopped 0.2 s after the last one while moving) and the service /hand/stop; and "
     "/hand/off, which switches its axes off. /hand/status has temperatures and the axes' states, "
     "/hand/device tells how good the line is. Never resumes a motion after a restart of either "
     "side. Its tactile pads are read by dsa."},
    run);

}  // namespace
