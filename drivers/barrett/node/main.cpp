#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/barrett/driver/device.h"
#include "drivers/barrett/driver/gcl/device.h"
#include "drivers/barrett/driver/health.h"
#include "drivers/barrett/node/hand_axes.h"
#include "drivers/barrett/node/hand_guard.h"
#include "drivers/barrett/node/pad_cells.h"
#include "drivers/barrett/node/settings.h"
#include "drivers/wire/guardian/guarded.h"
#include "drivers/wire/hand/hand_offers.h"
#include "drivers/wire/health/link_quality.h"
#include "drivers/wire/node/device_report.h"
#include "drivers/wire/node/joint_report.h"
#include "drivers/wire/node/wall_timer.h"
#include "msgs/hand.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::barrett;

constexpr double kRetry = 0.5;  // s between tries to open the bus

/// /joint_states: inner joints by the encoders behind the clutches, outer ones by both encoders,
/// their efforts by the strain gauges.
class Joints {
 public:
  Joints(const HandAxes& axes, JointReport& report) : axes_(axes), report_(report) {}
  void tell(const Reading& reading) {
    std::vector<double> efforts(axes_.moving_names().size(), 0.0);
    for (const HandAxes::Follower& follower : axes_.followers()) {
      efforts[follower.place] = reading.effort[follower.axis];
    }
    report_.tell(axes_.moving_values(reading.position, reading.joint),
                 axes_.moving_rates(reading.velocity, reading.joint_velocity), efforts);
  }

 private:
  const HandAxes& axes_;
  JointReport& report_;
};

/// /tactile/NAME of each pad.
class Pads {
 public:
  Pads(graph::Node& node, const Settings& settings, const robot::HandModel& hand,
       std::vector<graph::Publisher<msgs::TactileFrame>> publishers)
      : node_(node), publishers_(std::move(publishers)) {
    for (const std::string& pad : settings.pads) pads_.emplace_back(hand, pad, settings.cells);
  }
  void take(std::size_t axis, const Cells& cells) {
    if (axis >= pads_.size()) return;
    publishers_[axis].publish(pads_[axis].message(cells, node_.clock().now()));
  }

 private:
  graph::Node& node_;
  std::vector<PadCells> pads_;
  std::vector<graph::Publisher<msgs::TactileFrame>> publishers_;
};

/// Health, counters and temperatures, looked at in real time.
class Watcher {
 public:
  Watcher(graph::Node& node, const Settings& settings, HandDevice<HandDriver>& device,
          const JointReport& joints, const Guarded& guarded,
          nodes::EmergencyStopListener& emergency)
      : settings_(settings),
        device_(device),
        guarded_(guarded),
        joints_(joints),
        emergency_(emergency),
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
    situation.model = settings_.model;
    situation.line = settings_.wire;
    situation.hot = settings_.hot;
    DriverCounters counters;
    std::uint64_t damaged = 0;
    std::array<std::string, kAxes> words;
    device_.with_driver([&](HandDriver& driver, Time) {
      for (std::size_t i = 0; i < kAxes; ++i) words[i] = driver.axis_words(i);
      situation.reading = driver.reading();
      counters = driver.counters();
      damaged = driver.damaged();
    });
    const Reading& reading = situation.reading;
    connecting_ = reading.state == DriverState::kConnecting ? connecting_ + kPeriod : 0;
    situation.line_problem = device_.line_problem();
    situation.connecting = connecting_;
    if (reading.state <= DriverState::kLost) {
      quality_.restart();  // what is lost while nobody answers is no fault of the bus
    } else if (looks_ % kSample == 0) {
      quality_.sample(counters.replies, damaged + counters.unanswered, 0, steady_now());
    }
    situation.link_problem = quality_.problem();
    situation.guard_problem = guarded_.problem();
    was_ready_ = was_ready_ || reading.state > DriverState::kFault;
    emergency_.tell_device(was_ready_ ? own_stop(reading) : "");
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
    status.set_error_code(static_cast<std::uint32_t>(std::max(0, reading.error_code)));
    status.set_messages(counters.replies);
    status.set_damaged(damaged);
    status.set_unanswered(counters.unanswered);
    status.set_connections(counters.connections);
    status.set_rate(quality_.rate());
    status.set_damaged_part(quality_.harmed_part());
    publisher_.publish(status);
    if (reading.states > 0) tell(reading, words);
  }
  void tell(const Reading& reading, const std::array<std::string, kAxes>& words) {
    const auto are_all = [](const auto& values) {
      return std::ranges::all_of(values, [](const auto& one) { return one.has_value(); });
    };
    msgs::HandStatus status;
    status.mutable_header()->set_stamp(node_.clock().now());
    status.set_firmware(reading.firmware);
    for (std::size_t i = 0; i < kAxes; ++i) {
      status.add_name(settings_.axes[i]);
      status.add_axis_state(words[i]);
      status.add_blocked(reading.blocked[i]);
    }
    if (are_all(reading.motor_temperature)) {
      for (const auto& celsius : reading.motor_temperature) status.add_temperature(*celsius);
    }
    if (are_all(reading.puck_temperature)) {
      for (const auto& celsius : reading.puck_temperature) status.add_electronics(*celsius);
    } else if (reading.temperature) {
      status.add_electronics(*reading.temperature);
    }
    status_.publish(status);
  }

  const Settings& settings_;
  HandDevice<HandDriver>& device_;
  const Guarded& guarded_;
  const JointReport& joints_;
  nodes::EmergencyStopListener& emergency_;
  graph::Node& node_;
  DeviceReport report_;
  LinkQuality quality_;
  double connecting_ = 0;  // s
  double lonely_ = 0;      // s without the others' joints
  bool was_ready_ = false;
  int looks_ = 0;
  graph::Publisher<msgs::DeviceStatus> publisher_;
  graph::Publisher<msgs::HandStatus> status_;
  WallTimer timer_;
};

GuardianProgram guardian_of(const Settings& s) {
  return s.model == Model::kBh8_280 ? guardian_program(s.wire, s.bit_rate)
                                    : gcl::guardian_program(s.wire, s.gcl.baud, s.gcl.fast_baud);
}

std::unique_ptr<HandDevice<HandDriver>> make_device(const Settings& s, Device::OnState on_state,
                                                    Device::Note note, Device::OnRound on_round,
                                                    Driver::OnPad on_pad) {
  if (s.model == Model::kBh8_280) {
    return std::make_unique<Device>(
        s.can, [&s] { return open_hand_bus(s.wire, s.bit_rate); }, std::move(on_state),
        std::move(note), kRetry, std::move(on_round), std::move(on_pad));
  }
  return std::make_unique<gcl::Device>(
      s.gcl, [&s] { return open_byte_stream(s.wire, s.gcl.baud); }, std::move(on_state),
      std::move(note), kRetry, std::move(on_round));
}

void run(graph::Node& node) {
  Settings settings = declare_settings(node);
  // --help and --describe end here, before anything is read or opened.
  auto joint_publisher = node.advertise<msgs::JointState>("/joint_states", graph::QoS::queue(100));
  std::vector<graph::Publisher<msgs::TactileFrame>> pad_publishers;
  for (const std::string& pad : settings.pads) {
    pad_publishers.push_back(
        node.advertise<msgs::TactileFrame>("/tactile/" + pad, graph::QoS::queue(50)));
  }
  if (settings.pads.size() > kAxes) {
    throw geometry::InputError(fmt::format("{} pads for {} pucks", settings.pads.size(), kAxes),
                               "Give pads:= at most one a puck, in their order");
  }
  const HandAxes axes =
      hand_axes(robot::read_platform(robot::platform_file(settings.platforms, settings.platform)),
                settings.axes, settings.model, settings.gearing(), settings.most_torque);
  settings.can.limits = settings.gcl.limits = axes.limits<kAxes>();
  if (settings.model == Model::kBh8_262) {
    node.log_info("a BH8-262 has strain gauges and no pads: nothing is told on /tactile");
  }
  DeviceReport report(node);
  JointReport joint_report(node, axes.moving_names(), settings.other_joints,
                           std::move(joint_publisher));
  Joints joints(axes, joint_report);
  Pads pads(node, settings, axes.hand(), std::move(pad_publishers));
  // Begins before the device, so that it lives on until the device has stopped the hand.
  const auto guarded =
      settings.guardian
          ? std::make_unique<Guarded>(guardian_of(settings), settings.guardian_time, report.taker())
          : std::make_unique<Guarded>();
  const auto device = make_device(
      settings,
      [&](const Reading& reading) {
        if (reading.state > DriverState::kLost) joints.tell(reading);
      },
      report.taker(),
      [&](const Reading& reading) -> std::string {
        if (!guarded->progress(watch_of(reading))) return {};
        return "this driver made no progress, so its guardian stopped the hand";
      },
      [&](std::size_t axis, const Cells& cells) { pads.take(axis, cells); });
  nodes::EmergencyStopListener emergency(node);
  OfferedDevice<HandDevice<HandDriver>, kAxes> offered(*device, emergency);
  const HandOffers offers(node, offered, axes, emergency, false);
  // Answers at once, so that /hand/stop need not wait for it; the state is told on /hand/device.
  const auto initialise = node.serve<msgs::Empty, msgs::Acknowledge>(
      "/hand/initialise", [&device, &emergency](const msgs::Empty&) {
        std::uint64_t ticket = 0;
        const std::string refusal = device->with_driver([&](HandDriver& driver, Time now) {
          const std::string stopped = emergency.refusal();
          return stopped.empty() ? driver.initialise(now, ticket) : stopped;
        });
        msgs::Acknowledge answer;
        answer.set_success(refusal.empty());
        answer.set_reason(refusal.empty() ? "it opens" : refusal);
        return answer;
      });
  const Watcher watcher(node, settings, *device, joint_report, *guarded, emergency);
  node.spin();
}

const graph::RegisteredNodeProgram registered(
    {"barrett",
     "Drives a BarrettHand: a BH8-280 over CAN or a serial CAN adapter, or a BH8-262 over its "
     "serial "
     "line (model:=bh8_262). Offers what the simulated hand offers: publishes its joints on "
     "/joint_states (inner and outer links by the encoders on both sides of their clutches, of a "
     "BH8-262 by where it says that they opened, efforts by the strain gauges) and the pads of a "
     "BH8-280 on /tactile/NAME, takes the action /hand/move, the topic /hand/command (POSITION and "
     "VELOCITY; stopped 0.2 s after the last one while moving) and the service /hand/stop; and "
     "/hand/initialise, which opens it to its stops and has to be called before it moves. "
     "/hand/status has temperatures and the axes' states, /hand/device tells how good the line is. "
     "Never resumes a motion after a restart of either side."},
    run);

}  // namespace
