#include <atomic>
#include <memory>
#include <string>

#include "drivers/pg70/driver/health.h"
#include "drivers/pg70/node/gripper_guard.h"
#include "drivers/pg70/node/gripper_offers.h"
#include "drivers/wire/guardian/guarded.h"
#include "drivers/wire/health/link_quality.h"
#include "drivers/wire/node/device_report.h"
#include "drivers/wire/node/wall_timer.h"
#include "msgs/convert/gripper.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::pg70;

constexpr double kRetry = 0.5;  // s between tries to open the line

struct Settings {
  LinkAddress address;
  DriverOptions driver;
  std::string gripper;  // its file
  bool guardian = true;
  double guardian_time = Guardian::kPatience;  // s
};

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.address.line = node.declare_parameter<std::string>(
      {.name = "can",
       .default_value = "can0",
       .description = "a CAN interface, slcan:/dev/ttyACM0 (serial CAN adapter), or "
                      "serial:/dev/ttyUSB0 (the module's RS-232)",
       .read_only = true});
  s.address.bit_rate = static_cast<unsigned>(node.declare_parameter<int>(
      {.name = "bit_rate",
       .default_value = 0,
       .unit = "bit/s",
       .minimum = 0,
       .description = "CAN interface: compared with the system's; slcan: set; serial: baud, 0 is "
                      "9600; else 0: as it is",
       .read_only = true}));
  s.address.module = static_cast<std::uint8_t>(node.declare_parameter<int>(
      {.name = "module_id",
       .default_value = 12,
       .minimum = 1,
       .maximum = 255,
       .description = "of the gripper; its factory setting is not published",
       .read_only = true}));
  s.gripper = node.declare_parameter<std::string>(
      {.name = "gripper",
       .default_value = text::tree_file("config/robots/pg70_dsa.yaml"),
       .description = "gripper model: limits of opening, speed, acceleration, current",
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
      seconds("state_period", s.driver.state_period, 0.005, "between the module's states");
  s.driver.watchdog = seconds("watchdog", s.driver.watchdog, 0.01,
                              "without a command while moving, then it is stopped");
  s.driver.loss_time =
      seconds("loss_time", s.driver.loss_time, 0.02, "without a state, then it is stopped");
  s.driver.reply_time =
      seconds("reply_time", s.driver.reply_time, 0.01, "to wait for an answer before trying again");
  s.driver.blocked_time = seconds("blocked_time", s.driver.blocked_time, 0.02,
                                  "of standing, although told to move, that count as blocked");
  s.driver.stop_time = seconds("stop_time", s.driver.stop_time, 0.1,
                               "of motion after CMD STOP was answered, then CMD FAST STOP is sent");
  s.driver.holding_current = node.declare_parameter<double>(
      {.name = "holding_current",
       .default_value = s.driver.holding_current,
       .minimum = 0,
       .maximum = 1,
       .description = "part of the commanded current that the module shows while it holds "
                      "something; 0: its current is not looked at",
       .read_only = true});
  s.driver.opening_per_position = node.declare_parameter<double>(
      {.name = "opening_per_position",
       .default_value = 1,
       .minimum = 0.1,
       .maximum = 10,
       .description = "1: the module counts the whole opening, 2: the way of one finger",
       .read_only = true});
  s.driver.velocity_as_position =
      node.declare_parameter<std::string>(
          {.name = "velocity_by",
           .default_value = "position",
           .choices = {"position", "velocity"},
           .description = "a speed is commanded as MOVE POS to the end of the range, or MOVE VEL",
           .read_only = true}) == "position";
  s.driver.current_as_grip = node.declare_parameter<std::string>(
                                 {.name = "current_by",
                                  .default_value = "current",
                                  .choices = {"current", "grip"},
                                  .description = "a current is commanded as MOVE CUR, or MOVE GRIP",
                                  .read_only = true}) == "grip";
  s.guardian = node.declare_parameter<bool>(
      {.name = "guardian",
       .default_value = true,
       .description = "a process of its own stops the gripper when this one dies or hangs",
       .read_only = true});
  s.guardian_time = seconds("guardian_time", s.guardian_time, 0.1,
                            "without progress of this process while the gripper moves, then its "
                            "guardian stops it");
  const robot::GripperModel model = robot::read_gripper_model(s.gripper);
  s.driver.limits = {model.max_opening, model.max_speed, model.max_acceleration,
                     model.nominal_current, model.max_current};
  return s;
}

// States must fit the line beside commands: 20 bytes each on RS-232.
void check_line_rate(const Settings& s) {
  if (!s.address.line.starts_with("serial:/")) return;
  constexpr double kBitsOfState = 20 * 10, kShare = 0.7;
  const double baud = s.address.bit_rate > 0 ? s.address.bit_rate : kFactoryBaud;
  const double least = kBitsOfState / (baud * kShare);
  if (s.driver.state_period >= least) return;
  throw geometry::InputError(
      fmt::format("a state every {} s is too much for {} baud", s.driver.state_period, baud),
      fmt::format("Set state_period to at least {:.3f} and loss_time to three times that, or use a "
                  "higher bit_rate, in the module, too",
                  least));
}

/// Health and counters, looked at in real time.
class Watcher {
 public:
  Watcher(graph::Node& node, const Settings& settings, Device& device, const Guarded& guarded,
          nodes::EmergencyStopListener& emergency)
      : settings_(settings),
        device_(device),
        guarded_(guarded),
        emergency_(emergency),
        node_(node),
        report_(node),
        publisher_(node.advertise<msgs::DeviceStatus>("/gripper/device", graph::QoS::latched(1))),
        timer_(kPeriod, [this] { look(); }) {}

 private:
  static constexpr double kPeriod = 0.1;            // s
  static constexpr int kSample = 5, kPublish = 10;  // periods

  void look() {
    Situation situation;
    DriverCounters counters;
    device_.with_driver([&](Driver& driver, Time) {
      situation.reading = driver.reading();
      situation.obstacle = driver.obstacle();
      counters = driver.counters();
    });
    const DriverState state = situation.reading.state;
    connecting_ = state == DriverState::kConnecting ? connecting_ + kPeriod : 0;
    situation.address = settings_.address;
    situation.line_problem = device_.line_problem();
    situation.connecting = connecting_;
    situation.guard_problem = guarded_.problem();
    const std::uint64_t damaged = counters.strange + device_.damaged_messages();
    if (state < DriverState::kFault) {
      quality_.restart();  // what is lost while nobody answers is no fault of the line
    } else if (looks_ % kSample == 0) {
      quality_.sample(counters.states, damaged + counters.unanswered,
                      1 / settings_.driver.state_period, steady_now());
    }
    situation.link_problem = quality_.problem();
    was_ready_ = was_ready_ || state > DriverState::kUnreferenced;
    emergency_.tell_device(was_ready_ ? own_stop(situation.reading) : "");
    report_.tell(health_of(situation));
    if (looks_++ % kPublish != 0) return;
    msgs::DeviceStatus status;
    status.mutable_header()->set_stamp(node_.clock().now());
    status.set_state(to_string(state));
    status.set_error_code(situation.reading.error_code);
    status.set_warning_code(situation.reading.warning_code);
    status.set_messages(counters.states);
    status.set_damaged(damaged);
    status.set_unanswered(counters.unanswered);
    status.set_connections(counters.connections);
    status.set_rate(quality_.rate());
    status.set_damaged_part(quality_.harmed_part());
    publisher_.publish(status);
  }

  const Settings& settings_;
  Device& device_;
  const Guarded& guarded_;
  nodes::EmergencyStopListener& emergency_;
  graph::Node& node_;
  DeviceReport report_;
  LinkQuality quality_;
  double connecting_ = 0;   // s
  bool was_ready_ = false;  // before that nothing that stands still by itself was to move
  int looks_ = 0;
  graph::Publisher<msgs::DeviceStatus> publisher_;
  WallTimer timer_;
};

void run(graph::Node& node) {
  const Settings settings = declare_settings(node);
  check_line_rate(settings);
  const auto description =
      node.advertise<msgs::GripperDescription>("/gripper/model", graph::QoS::latched(1));
  description.publish(convert::describe_gripper(settings.gripper));
  DeviceReport report(node);
  const auto publisher =
      node.advertise<msgs::GripperState>("/gripper/state", graph::QoS::queue(100));
  // Begins before the device, so that it lives on until the device has stopped the gripper.
  const auto guarded = settings.guardian
                           ? std::make_unique<Guarded>(guardian_program(settings.address),
                                                       settings.guardian_time, report.taker())
                           : std::make_unique<Guarded>();
  std::atomic<Device*> itself = nullptr;
  Device device(
      settings.driver, [&] { return open_link(settings.address); },
      [&](const Reading& reading) {
        if (reading.states > 0) publisher.publish(state_message(reading, node.clock().now()));
      },
      report.taker(), kRetry,
      [&](const Reading& reading) {
        if (!guarded->progress(watch_of(reading)) || !itself) return;
        itself.load()->begin_anew(
            "this driver made no progress, so its guardian stopped the gripper");
      });
  itself = &device;
  nodes::EmergencyStopListener emergency(node);
  const GripperOffers offers(node, device, emergency);
  const Watcher watcher(node, settings, device, *guarded, emergency);
  node.spin();
}

const graph::RegisteredNodeProgram registered(
    {"pg70",
     "Drives a Schunk PG70 gripper over CAN, a serial CAN adapter or RS-232 (Schunk Motion "
     "Protocol). Offers what the simulated gripper offers: publishes /gripper/model and "
     "/gripper/state; takes "
     "/gripper/command (stopped 0.2 s after the last one while moving), the action /gripper/move, "
     "the services /gripper/stop, /gripper/fast_stop (motor shorted until it is acknowledged), "
     "/gripper/acknowledge and /gripper/reference; /gripper/device tells how good the wire is. "
     "Never "
     "resumes a motion after a restart of either side."},
    run);

}  // namespace
