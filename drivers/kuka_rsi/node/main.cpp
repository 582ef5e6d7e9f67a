#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "drivers/kuka_rsi/driver/device.h"
#include "drivers/kuka_rsi/node/health.h"
#include "drivers/kuka_rsi/node/rsi_arm.h"
#include "drivers/wire/health/link_quality.h"
#include "drivers/wire/node/device_report.h"
#include "drivers/wire/node/joint_report.h"
#include "drivers/wire/node/wall_timer.h"
#include "msgs/joints.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/platform_source/platform_source.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::kuka_rsi;

struct NodeSettings {
  std::string platform, platforms, other_joints;
  DeviceOptions device;
  Limits::Options limits;
  std::vector<double> box;
  double path_tolerance = 0.1;
};

double declare_number(graph::Node& node, const char* name, double value, const char* unit,
                      double least, double most, const char* words) {
  return node.declare_parameter<double>({.name = name,
                                         .default_value = value,
                                         .unit = unit,
                                         .minimum = least,
                                         .maximum = most,
                                         .description = words,
                                         .read_only = true});
}

std::string declare_text(graph::Node& node, const char* name, const std::string& value,
                         const char* words) {
  return node.declare_parameter<std::string>(
      {.name = name, .default_value = value, .description = words, .read_only = true});
}

int declare_count(graph::Node& node, const char* name, int value, int least, int most,
                  const char* words) {
  return node.declare_parameter<int>({.name = name,
                                      .default_value = value,
                                      .minimum = least,
                                      .maximum = most,
                                      .description = words,
                                      .read_only = true});
}

void declare_wire(graph::Node& node, DeviceOptions& d) {
  d.host = declare_text(node, "host", d.host,
                        "IPv4 address of this machine that the controller sends to (IP_NUMBER); "
                        "0.0.0.0: any");
  d.port = declare_count(node, "port", d.port, 1, 65535, "UDP port of the same (PORT)");
  d.controller = declare_text(node, "controller", d.controller,
                              "IPv4 address that alone is answered; empty: who sends first");
  const int cycle = declare_count(node, "cycle", 12, 4, 12, "of the controller [ms]: 12, or 4");
  if (cycle != 12 && cycle != 4) throw std::invalid_argument("parameter 'cycle' is 12 or 4 ms");
  d.driver.cycle = 1e-3 * cycle;
  d.priority = declare_count(node, "priority", d.priority, 0, 99,
                             "of real-time scheduling; 0: not asked for");
  TelegramNames& names = d.driver.names;
  names.type = declare_text(node, "type", names.type, "SENTYPE");
  names.correction = declare_text(node, "correction", names.correction,
                                  "element of the axes' correction: a free name, AK with others");
  names.message = declare_text(node, "message", names.message,
                               "element for messages to the controller; empty: it has none");
  names.actual_axes = declare_text(node, "actual_axes", names.actual_axes, "element of DEF_AIPos");
  names.commanded_axes =
      declare_text(node, "commanded_axes", names.commanded_axes, "element of DEF_ASPos");
  names.actual_pose = declare_text(node, "actual_pose", names.actual_pose, "element of DEF_RIst");
  names.delay = declare_text(node, "delay", names.delay, "element of DEF_Delay");
  names.decimals = declare_count(node, "decimals", names.decimals, 3, 9, "of the correction [deg]");
}

void declare_driver(graph::Node& node, DriverOptions& d) {
  d.late_limit = declare_count(
      node, "late_limit", d.late_limit, 1, 1000,
      "telegrams without an accepted answer that stop a motion: in a row, or more by so many than "
      "there were hundreds of accepted ones between them");
  d.loss_cycles = declare_count(node, "loss_cycles", d.loss_cycles, 4, 10000,
                                "without a telegram, then RSI is held to have ended");
  d.start_tolerance = declare_number(node, "start_tolerance", d.start_tolerance, "rad", 1e-5, 0.1,
                                     "between actual and programmed axes when RSI begins");
  d.lag = declare_number(node, "lag", d.lag, "s", 0.01, 6,
                         "by which the arm may be behind its set points");
  d.settle_time = declare_number(node, "settle_time", d.settle_time, "s", 0.05, 60,
                                 "after the last set point, in which the arm has to be there");
  d.settled = declare_number(node, "settled", d.settled, "rad", 1e-5, 0.1, "from the goal");
  d.force_age =
      declare_number(node, "force_age", d.force_age, "s", 0.01, 10,
                     "of the last /wrench while contact is minded, then the arm is stopped");
}

void declare_limits(graph::Node& node, NodeSettings& s) {
  s.limits.speed_share = declare_number(node, "speed_share", s.limits.speed_share, "", 0.001, 1,
                                        "of the joints' greatest speeds, of the robot's file");
  s.limits.acceleration = declare_number(node, "acceleration", s.limits.acceleration, "rad/s^2",
                                         0.01, 1000, "of each axis, also of braking");
  s.limits.largest_correction =
      declare_number(node, "largest_correction", s.limits.largest_correction, "rad", 0.001, 12.6,
                     "of an axis from where the controller's program stands; below its "
                     "own limits (AXISCORR, AXISCORRMON)");
  s.path_tolerance = declare_number(node, "path_tolerance", s.path_tolerance, "rad", 1e-4, 3,
                                    "off the path beyond its lag, of goals that give none");
  s.box = node.declare_parameter<std::vector<double>>(
      {.name = "tool_box",
       .default_value = {},
       .description = "where the tool may be in the world [m]: x y z of the lower corner, x y z of "
                      "the upper one; empty: anywhere the axes reach",
       .read_only = true});
}

NodeSettings declare_settings(graph::Node& node) {
  NodeSettings s;
  s.platform = declare_text(node, "platform", "kr5_pg70", "whose arm it is, of config/robots");
  s.platforms = nodes::declare_platforms(node);
  s.other_joints = declare_text(node, "other_joints", "",
                                "topic whose joints, those of the hand, are told with the arm's on "
                                "/joint_states; empty: none");
  declare_wire(node, s.device);
  declare_driver(node, s.device.driver);
  declare_limits(node, s);
  return s;
}

Limits limits_of(graph::Node& node, NodeSettings& s, const robot::Platform& platform) {
  s.limits.X_WB = platform.X_WB;
  s.limits.p_FT = platform.X_FG(platform.hand.preshapes.front()).translation();
  if (s.box.empty()) {
    node.log_warning("no tool_box: the tool may go anywhere the axes reach");
  } else if (s.box.size() != 6) {
    throw std::invalid_argument("parameter 'tool_box' has " + std::to_string(s.box.size()) +
                                " numbers; give x y z x y z, or none");
  } else {
    s.limits.box = ToolBox{{s.box[0], s.box[1], s.box[2]}, {s.box[3], s.box[4], s.box[5]}};
  }
  return {platform.arm_chain(), s.limits};
}

/// Tells where the axes are, whenever a telegram has told that since the last time.
class AxesTeller {
 public:
  AxesTeller(const Device& device, JointReport& joints) : device_(device), joints_(joints) {}
  void tell() {
    const Snapshot now = device_.snapshot();
    if (now.state == State::kSilent || now.telegrams == told_) return;
    told_ = now.telegrams;
    joints_.tell(now.actual, now.velocity);
  }

 private:
  const Device& device_;
  JointReport& joints_;
  std::uint64_t told_ = 0;
};

/// Health and counters.
class Watcher {
 public:
  Watcher(graph::Node& node, const Device& device, const DeviceOptions& options,
          nodes::EmergencyStopListener& emergency)
      : node_(node),
        device_(device),
        options_(options),
        emergency_(emergency),
        report_(node),
        publisher_(node.advertise<msgs::DeviceStatus>("/arm/device", graph::QoS::latched(1))),
        timer_(kPeriod, [this] { look(); }) {}

 private:
  static constexpr double kPeriod = 0.1;            // s
  static constexpr double kGrace = 2;               // s at first: the controller may be starting
  static constexpr int kSample = 5, kPublish = 10;  // periods

  void look() {
    const Snapshot now = device_.snapshot();
    const std::uint64_t harmed = now.damaged + now.missing + now.late;
    if (now.state == State::kSilent || now.state == State::kRefused) {
      quality_.restart();
    } else if (looks_ % kSample == 0) {
      quality_.sample(now.telegrams, harmed, 1 / options_.driver.cycle, steady_now());
    }
    tell_events(now);
    emergency_.tell_device(own_stops_.look(now, device_.peer()));
    const bool is_early = now.telegrams == 0 && looks_ * kPeriod < kGrace;
    report_.tell(is_early ? Health{Health::Level::kOk, "waits for the controller"}
                          : health_of(now, device_.peer(), quality_.problem(),
                                      device_.missing_real_time(), options_.port));
    if (looks_++ % kPublish != 0) return;
    msgs::DeviceStatus status;
    status.mutable_header()->set_stamp(node_.clock().now());
    status.set_state(to_string(now.state));
    status.set_messages(now.telegrams);
    status.set_damaged(now.damaged + now.missing);
    status.set_unanswered(now.late);
    status.set_connections(now.sessions);
    status.set_rate(quality_.rate());
    status.set_damaged_part(quality_.harmed_part());
    publisher_.publish(status);
  }
  void tell_events(const Snapshot& now) {
    if (now.sessions != sessions_) {
      sessions_ = now.sessions;
      node_.log_info("RSI began: controller {}", device_.peer());
    }
    if (now.late + now.missing > lost_) {
      node_.log_warning("{} telegrams were lost and {} answers late until now", now.missing,
                        now.late);
      lost_ = 2 * (now.late + now.missing);  // ever more seldom
    }
  }

  graph::Node& node_;
  const Device& device_;
  const DeviceOptions options_;
  nodes::EmergencyStopListener& emergency_;
  DeviceReport report_;
  LinkQuality quality_;
  int looks_ = 0;
  OwnStops own_stops_;
  std::uint64_t sessions_ = 0, lost_ = 0;
  graph::Publisher<msgs::DeviceStatus> publisher_;
  WallTimer timer_;
};

msgs::Acknowledge acknowledged(bool success, const std::string& reason = {}) {
  msgs::Acknowledge answer;
  answer.set_success(success);
  answer.set_reason(reason);
  return answer;
}

void tell_answer_times(graph::Node& node, const Device& device) {
  const AnswerTimes times = device.answer_times();
  std::string text;
  for (std::size_t i = 0; i < times.counts.size(); ++i) {
    if (times.counts[i] == 0) continue;
    const bool is_last = i == AnswerTimes::kBounds.size();
    text +=
        fmt::format("{}{} {} {} ms", text.empty() ? "" : ", ", times.counts[i],
                    is_last ? "beyond" : "within", 1e3 * AnswerTimes::kBounds[is_last ? i - 1 : i]);
  }
  if (!text.empty()) node.log_info("answers: {}; longest {:.2f} ms", text, 1e3 * times.longest);
}

void run(graph::Node& node) {
  NodeSettings settings = declare_settings(node);
  // --help and --describe end here, before anything is read or opened.
  auto joint_publisher = node.advertise<msgs::JointState>("/joint_states", graph::QoS::queue(100));
  const robot::Platform platform =
      robot::read_platform(robot::platform_file(settings.platforms, settings.platform));
  const Limits limits = limits_of(node, settings, platform);
  DeviceReport report(node);
  Device device(settings.device, limits, report.taker());
  RsiArm arm(device, limits, settings.device.driver.cycle, settings.path_tolerance);
  const auto wrench = node.subscribe<msgs::Wrench>(
      "/wrench", graph::QoS::latest(), [&](const graph::Received<msgs::Wrench>& message) {
        const auto& force = message->wrench().force();
        device.feel(std::hypot(force.x(), force.y(), force.z()));
      });
  nodes::EmergencyStopListener emergency(node);
  const nodes::ArmAction action(node, arm, emergency);
  const graph::Service fast_stop =
      node.serve<msgs::Empty, msgs::Acknowledge>("/arm/fast_stop", [&](const msgs::Empty&) {
        device.latch();
        return acknowledged(true);
      });
  const graph::Service acknowledge =
      node.serve<msgs::Empty, msgs::Acknowledge>("/arm/acknowledge", [&](const msgs::Empty&) {
        const bool was_latched = device.release();
        return acknowledged(was_latched, was_latched ? "" : "there was nothing to acknowledge");
      });
  std::vector<std::string> names;
  for (const robot::ChainJoint& joint : limits.chain().joints()) names.push_back(joint.name);
  JointReport joints(node, names, settings.other_joints, std::move(joint_publisher));
  AxesTeller teller(device, joints);
  constexpr double kJointPeriod = 0.02;  // s, as usual; each message wakes several threads
  const WallTimer timer(kJointPeriod, [&] { teller.tell(); });
  const Watcher watcher(node, device, settings.device, emergency);
  node.spin();
  tell_answer_times(node, device);
}

const graph::RegisteredNodeProgram registered(
    {"kuka_rsi",
     "Drives a KUKA robot over RSI 2.x or 3.x (UDP, absolute corrections of the axes): answers "
     "each "
     "telegram of the controller in its cycle, serves /arm/follow, publishes /joint_states, and "
     "holds the arm to limits of position, speed, acceleration and a box for its tool. Contact by "
     "/wrench stops it within a cycle. /arm/stop brakes; /arm/fast_stop brakes until "
     "/arm/acknowledge; /arm/device tells how good the network is."},
    run);

}  // namespace
