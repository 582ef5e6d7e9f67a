#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/sdh/emulator/hand.h"
#include "drivers/sdh/node/hand_axes.h"
#include "drivers/wire/faults/faulty_stream.h"
#include "drivers/wire/hand/graph_hand.h"
#include "drivers/wire/node/fault_parameters.h"
#include "drivers/wire/node/linger.h"
#include "drivers/wire/stream/emulated_line.h"
#include "drivers/wire/stream/served_device.h"
#include "nodes/platform_source/platform_source.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::sdh;

struct Settings {
  std::string line, platform, platforms;
  std::vector<std::string> axes;
  double most_current = 1;  // A
  HandOptions options;
};

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.line = node.declare_parameter<std::string>(
      {.name = "line",
       .default_value = "/tmp/prehend_sdh",
       .description = "the emulated serial line is made under this name; tcp:PORT: a TCP port",
       .read_only = true});
  s.platform = node.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "kr5_sdh",
       .description = "whose hand it is: joints, limits of position, speed and effort",
       .read_only = true});
  s.platforms = nodes::declare_platforms(node);
  s.axes = node.declare_parameter<std::vector<std::string>>(
      {.name = "axes",
       .default_value = kSdh2Axes,
       .description = "the world's joints, in the order of the device's axes 0 to 6",
       .read_only = true});
  s.most_current = node.declare_parameter<double>(
      {.name = "most_current",
       .default_value = s.most_current,
       .unit = "A",
       .minimum = 0.01,
       .maximum = 1,
       .description = "current of a motor at its joint's greatest effort",
       .read_only = true});
  const auto firmware = node.declare_parameter<std::string>(
      {.name = "firmware",
       .default_value = s.options.firmware.text(),
       .description = "version: 0.0.2.6 has no ramp and no binary messages, 0.0.2.16 says debug "
                      "lines before some replies",
       .read_only = true,
       .validate = [](const std::string& text) {
         return firmware_of(text) ? "" : "a firmware is four numbers, e.g. 0.0.3.3";
       }});
  s.options.firmware = firmware_of(firmware).value_or(s.options.firmware);
  s.options.boot_time = node.declare_parameter<double>({.name = "boot_time",
                                                        .default_value = s.options.boot_time,
                                                        .unit = "s",
                                                        .minimum = 0,
                                                        .maximum = 60,
                                                        .description = "of silence after reboot",
                                                        .read_only = true});
  s.options.blocked_time = node.declare_parameter<double>(
      {.name = "blocked_time",
       .default_value = s.options.blocked_time,
       .unit = "s",
       .minimum = 0.01,
       .maximum = 10,
       .description = "of standing, by the simulation's clock, that shows as blocked",
       .read_only = true});
  const bool is_tcp = s.line.starts_with("tcp:");
  s.options.has_checksum = !is_tcp;
  if (is_tcp) s.options.baud = 0;
  return s;
}

void run(graph::Node& node) {
  Settings settings = declare_settings(node);
  LineFaultParameters line_faults(node);
  Switch mute(node, "mute", "nothing that it says arrives, as of a hand that is too hot");
  Switch stuck(node, "stuck", "the fingers cannot move");
  Switch reboot(node, "reboot", "set to true: its supply goes off and on");
  Switch debug_lines(node, "debug_lines", "it says @ lines before some replies");
  LateParameter<std::string> deaf_to(
      node, {.name = "deaf_to",
             .default_value = "",
             .description = "command that gets lost on its way to it, e.g. stop; empty: none",
             .validate = [](const std::string& name) {
               return name.empty() || command_named(name) ? "" : "no command of an SDH-2";
             }});
  LateParameter<int> refusal(node, {.name = "refusal",
                                    .default_value = 0,
                                    .minimum = 0,
                                    .maximum = kLastReturnCode,
                                    .description = "what sets or moves is answered with this code, "
                                                   "e.g. 28 axis disabled, 29 over-temperature; 0: "
                                                   "none"});
  LateParameter<double> temperature(node, {.name = "temperature",
                                           .default_value = 25,
                                           .unit = "degC",
                                           .minimum = -20,
                                           .maximum = 150,
                                           .description = "of motors and boards, from now on"});
  // --help and --describe end here, before anything is read or opened.
  auto command_publisher =
      node.advertise<msgs::JointCommand>("/world/hand/command", graph::QoS::queue(20));
  const HandAxes axes =
      hand_axes(robot::read_platform(robot::platform_file(settings.platforms, settings.platform)),
                settings.axes, settings.most_current);
  GraphHand<kAxes> plant(node, axes, std::move(command_publisher));
  settings.options.plant = &plant;
  auto stream = std::make_unique<FaultyStream>(make_emulated_line(settings.line));
  FaultyStream* const line = stream.get();
  ServedDevice<Hand> hand(settings.options, std::move(stream));
  line_faults.connect([line](const LineFaults& faults) { line->set_faults(faults); });
  mute.connect([&](bool on) { hand.with_device([on](Hand& h, Time) { h.set_mute(on); }); });
  stuck.connect([&](bool on) { plant.set_stuck(on); });
  reboot.connect([&](bool on) {
    if (on) hand.with_device([](Hand& h, Time now) { h.reboot(now); });
  });
  debug_lines.connect(
      [&](bool on) { hand.with_device([on](Hand& h, Time) { h.set_debug_lines(on); }); });
  deaf_to.connect([&](const std::string& name) {
    hand.with_device([&](Hand& h, Time) { h.set_deaf_to(command_named(name)); });
  });
  refusal.connect([&](int code) {
    hand.with_device([code](Hand& h, Time) { h.set_refusal(static_cast<std::uint8_t>(code)); });
  });
  temperature.connect([&](double celsius) {
    hand.with_device([celsius](Hand& h, Time) { h.set_temperature(celsius); });
  });
  node.log_info("SDH-2, firmware {}, on {}", settings.options.firmware.text(), settings.line);
  node.spin();
  linger();
}

const graph::RegisteredNodeProgram registered(
    {"sdh_emulator",
     "Stands in for a Schunk SDH-2 at the other end of its line: answers as far as the vendor's "
     "library shows its language, moves the simulated hand by /world/hand/command and follows its "
     "joints on /world/joint_states. Faults of the line and of the device are parameters that may "
     "be set while it runs. Its pads are those of dsa_emulator."},
    run);

}  // namespace
