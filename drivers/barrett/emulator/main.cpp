#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/barrett/emulator/served_hand.h"
#include "drivers/barrett/node/hand_axes.h"
#include "drivers/barrett/node/pad_cells.h"
#include "drivers/barrett/node/settings.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/faults/faulty_can.h"
#include "drivers/wire/hand/graph_hand.h"
#include "drivers/wire/node/fault_parameters.h"
#include "drivers/wire/node/linger.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "nodes/platform_source/platform_source.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::barrett;

struct EmulatorSettings {
  std::string bus, platform, platforms;
  std::vector<std::string> axes, pads;
  HandOptions options;
};

EmulatorSettings declare_emulator_settings(graph::Node& node) {
  EmulatorSettings s;
  s.bus = node.declare_parameter<std::string>(
      {.name = "can",
       .default_value = "slcan:/tmp/prehend_barrett",
       .description = "a CAN interface, or slcan:FILE: the emulated adapter's line is made there",
       .read_only = true});
  s.platform = node.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "pa10_barrett",
       .description = "whose hand it is: joints, limits of position, speed and effort, pads",
       .read_only = true});
  s.platforms = nodes::declare_platforms(node);
  s.axes = node.declare_parameter<std::vector<std::string>>(
      {.name = "axes",
       .default_value = kBh8Axes,
       .description = "the world's joints, in the order of the pucks F1, F2, F3, spread",
       .read_only = true});
  s.pads = node.declare_parameter<std::vector<std::string>>(
      {.name = "pads",
       .default_value = kBh8Pads,
       .description = "the world's pads, in the order of the pucks, from /world/tactile/NAME",
       .read_only = true});
  s.options.most_torque = node.declare_parameter<double>(
      {.name = "most_torque",
       .default_value = 2200,
       .minimum = 1,
       .maximum = 8191,
       .description = "torque in the pucks' unit (MT) at its joint's greatest effort",
       .read_only = true});
  s.options.gearing = declare_gearing(node, Model::kBh8_280);
  s.options.has_joint_encoders = node.declare_parameter<bool>(
      {.name = "joint_encoders",
       .default_value = true,
       .description = "the fingers have encoders behind their clutches",
       .read_only = true});
  s.options.is_awake = node.declare_parameter<bool>(
      {.name = "awake",
       .default_value = false,
       .description = "at the start; else its pucks are in monitor mode until they are woken",
       .read_only = true});
  s.options.wake_time = node.declare_parameter<double>({.name = "wake_time",
                                                        .default_value = s.options.wake_time,
                                                        .unit = "s",
                                                        .minimum = 0,
                                                        .maximum = 10,
                                                        .description = "of silence while it wakes",
                                                        .read_only = true});
  return s;
}

std::unique_ptr<CanBus> make_bus(const std::string& name) {
  constexpr std::string_view kSlcan = "slcan:";
  if (name.starts_with(kSlcan)) {
    return std::make_unique<Slcan>(std::make_unique<PseudoTerminal>(name.substr(kSlcan.size())), 0,
                                   std::vector<std::uint16_t>{});
  }
  std::vector<std::uint16_t> identifiers;
  for (std::size_t i = 0; i < kAxes; ++i) identifiers.push_back(request_identifier(i));
  return open_can_bus(name, 0, identifiers);
}

void run_emulator(graph::Node& node) {
  EmulatorSettings settings = declare_emulator_settings(node);
  LineFaultParameters line_faults(node);
  Switch mute(node, "mute", "nothing that it says arrives");
  Switch stuck(node, "stuck", "the fingers cannot move");
  Switch reboot(node, "reboot", "set to true: its supply goes off and on");
  Switch error(node, "error", "its pucks show STAT 1");
  Switch pads_fail(node, "pads_fail", "its pads are not initialised (TACTID -2)");
  LateParameter<std::string> deaf_to(
      node,
      {.name = "deaf_to",
       .default_value = "",
       .description = "property whose setting gets lost on its way to it, e.g. MODE, CMD, MT; "
                      "empty: none",
       .validate = [](const std::string& name) {
         return name.empty() || property_named(name) ? "" : "no property that is used here";
       }});
  LateParameter<double> temperature(node, {.name = "temperature",
                                           .default_value = 25,
                                           .unit = "degC",
                                           .minimum = -20,
                                           .maximum = 150,
                                           .description = "of motors and pucks, from now on"});
  // --help and --describe end here, before anything is read or opened.
  auto command_publisher =
      node.advertise<msgs::JointCommand>("/world/hand/command", graph::QoS::queue(20));
  const HandAxes axes = hand_axes(
      robot::read_platform(robot::platform_file(settings.platforms, settings.platform)),
      settings.axes, Model::kBh8_280, settings.options.gearing, settings.options.most_torque);
  std::vector<PadCells> pads;
  for (const std::string& pad : settings.pads)
    pads.emplace_back(axes.hand(), pad, std::vector<std::size_t>{});
  GraphHand<kAxes> plant(node, axes, std::move(command_publisher));
  settings.options.plant = &plant;
  auto bus = std::make_unique<FaultyCan>(make_bus(settings.bus));
  FaultyCan* const line = bus.get();
  ServedHand hand(settings.options, std::move(bus));
  std::vector<graph::Subscription> subscriptions;
  for (std::size_t i = 0; i < std::min(pads.size(), kAxes); ++i) {
    subscriptions.push_back(node.subscribe<msgs::TactileFrame>(
        "/world/tactile/" + pads[i].name(), graph::QoS::latest(),
        [&hand, &pad = pads[i], i](const graph::Received<msgs::TactileFrame>& frame) {
          const Cells cells = pad.cells(*frame);
          hand.with_hand([&](Hand& h, Time) { h.set_cells(i, cells); });
        }));
  }
  line_faults.connect([line](const LineFaults& faults) { line->set_faults(faults); });
  mute.connect([&](bool on) { hand.with_hand([on](Hand& h, Time) { h.set_mute(on); }); });
  stuck.connect([&](bool on) { plant.set_stuck(on); });
  reboot.connect([&](bool on) {
    if (on) hand.with_hand([](Hand& h, Time now) { h.reboot(now); });
  });
  bool is_in_error = false;
  error.connect([&](bool on) {
    if (on == is_in_error) return;
    is_in_error = on;
    hand.with_hand([on](Hand& h, Time) { h.set_error(on); });
  });
  pads_fail.connect(
      [&](bool on) { hand.with_hand([on](Hand& h, Time) { h.set_pad_failure(on); }); });
  deaf_to.connect([&](const std::string& name) {
    hand.with_hand([&](Hand& h, Time) { h.set_deaf_to(property_named(name)); });
  });
  temperature.connect([&](double celsius) {
    hand.with_hand([celsius](Hand& h, Time) { h.set_temperature(celsius); });
  });
  node.log_info("BH8-280 on {}", settings.bus);
  node.spin();
  linger();
}

const graph::RegisteredNodeProgram registered_emulator(
    {"barrett_emulator",
     "Stands in for a BarrettHand BH8-280 at the other end of its bus: four pucks that answer as "
     "Barrett's software shows it, move the simulated hand by /world/hand/command, follow its "
     "joints on /world/joint_states and tell what its pads feel on /world/tactile. Faults of the "
     "bus and of the device are parameters that may be set while it runs."},
    run_emulator);

}  // namespace
