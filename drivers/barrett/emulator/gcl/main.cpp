#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/barrett/emulator/gcl/hand.h"
#include "drivers/barrett/node/hand_axes.h"
#include "drivers/barrett/node/settings.h"
#include "drivers/wire/faults/faulty_stream.h"
#include "drivers/wire/hand/graph_hand.h"
#include "drivers/wire/node/fault_parameters.h"
#include "drivers/wire/node/linger.h"
#include "drivers/wire/stream/emulated_line.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "nodes/platform_source/platform_source.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::barrett;

struct SerialSettings {
  std::string line, platform, platforms;
  std::vector<std::string> axes;
  gcl::HandOptions options;
};

SerialSettings declare_serial_settings(graph::Node& node) {
  SerialSettings s;
  s.line = node.declare_parameter<std::string>(
      {.name = "line",
       .default_value = "/tmp/prehend_barrett",
       .description = "the emulated serial line is made under this name; tcp:PORT: a TCP port, "
                      "which has no rate",
       .read_only = true});
  s.platform = node.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "pa10_barrett",
       .description = "whose hand it is: joints, limits of position, speed and effort",
       .read_only = true});
  s.platforms = nodes::declare_platforms(node);
  s.axes = node.declare_parameter<std::vector<std::string>>(
      {.name = "axes",
       .default_value = kBh8Axes,
       .description = "the world's joints, in the order of the motors F1, F2, F3, spread",
       .read_only = true});
  s.options.gearing = declare_gearing(node, Model::kBh8_262);
  const auto firmware = node.declare_parameter<std::string>(
      {.name = "firmware",
       .default_value = "4.3",
       .choices = {"4.3", "4.4"},
       .description = "4.4 has LCT, LFBP and LFAIN, and one byte of LFT where 4.3 has two",
       .read_only = true});
  s.options.firmware = gcl::firmware_of(firmware).value_or(s.options.firmware);
  s.options.baud = static_cast<unsigned>(
      node.declare_parameter<int>({.name = "baud",
                                   .default_value = static_cast<int>(s.options.baud),
                                   .unit = "bit/s",
                                   .choices = {gcl::kBauds.begin(), gcl::kBauds.end()},
                                   .description = "as stored: after power-on and RESET",
                                   .read_only = true}));
  s.options.prints_abort = node.declare_parameter<bool>(
      {.name = "prints_abort",
       .default_value = s.options.prints_abort,
       .description = "Ctrl-C says ERR 16384 in RealTime mode and while it stands, too",
       .read_only = true});
  s.options.velocity_factor = node.declare_parameter<int>(
      {.name = "velocity_factor",
       .default_value = s.options.velocity_factor,
       .choices = {1, 16},
       .description = "parts of a count per 10 ms that LCV is counted in",
       .read_only = true});
  s.options.boot_time =
      node.declare_parameter<double>({.name = "boot_time",
                                      .default_value = s.options.boot_time,
                                      .unit = "s",
                                      .minimum = 0,
                                      .maximum = 60,
                                      .description = "from power-on to its banner",
                                      .read_only = true});
  return s;
}

void run_serial_emulator(graph::Node& node) {
  SerialSettings settings = declare_serial_settings(node);
  LineFaultParameters line_faults(node);
  Switch mute(node, "mute", "nothing that it says arrives");
  Switch no_prompt(node, "no_prompt", "its answers have no prompt");
  Switch stuck(node, "stuck", "the fingers cannot move");
  Switch reboot(node, "reboot", "set to true: its supply goes off and on");
  Switch no_gauges(node, "no_gauges", "SG of its fingers is 255: there are no strain gauges");
  LateParameter<double> prompt_delay(node, {.name = "prompt_delay",
                                            .default_value = 0,
                                            .unit = "s",
                                            .minimum = 0,
                                            .maximum = 30,
                                            .description = "by which its answers come late"});
  LateParameter<int> refusal(node, {.name = "refusal",
                                    .default_value = 0,
                                    .minimum = 0,
                                    .maximum = 32767,
                                    .description = "commands and blocks are answered by this ERR, "
                                                   "e.g. 16, 8192, 16384; 0: none"});
  LateParameter<int> lost_echoes(node, {.name = "lost_echoes",
                                        .default_value = 0,
                                        .minimum = 0,
                                        .description = "that many bytes of echoes get lost"});
  LateParameter<int> garbled_blocks(node, {.name = "garbled_blocks",
                                           .default_value = 0,
                                           .minimum = 0,
                                           .description = "that many feedback blocks have a wrong "
                                                          "byte"});
  LateParameter<int> short_blocks(node, {.name = "short_blocks",
                                         .default_value = 0,
                                         .minimum = 0,
                                         .description = "that many feedback blocks miss a byte"});
  LateParameter<double> temperature(node, {.name = "temperature",
                                           .default_value = 25,
                                           .unit = "degC",
                                           .minimum = -20,
                                           .maximum = 150,
                                           .description = "of the hand; from 65 on it does not "
                                                          "move (ERR 8192)"});
  // --help and --describe end here, before anything is read or opened.
  auto command_publisher =
      node.advertise<msgs::JointCommand>("/world/hand/command", graph::QoS::queue(20));
  const HandAxes axes = hand_axes(
      robot::read_platform(robot::platform_file(settings.platforms, settings.platform)),
      settings.axes, Model::kBh8_262, settings.options.gearing, settings.options.most_command);
  GraphHand<kAxes> plant(node, axes, std::move(command_publisher));
  settings.options.plant = &plant;
  auto end = make_emulated_line(settings.line);
  if (const auto* const terminal = dynamic_cast<const PseudoTerminal*>(end.get())) {
    settings.options.host_baud = [terminal] { return terminal->baud(); };
  }
  auto stream = std::make_unique<FaultyStream>(std::move(end));
  FaultyStream* const line = stream.get();
  ServedDevice<gcl::Hand> hand(settings.options, std::move(stream));
  const auto with = [&hand](const auto& work) {
    hand.with_device([&](gcl::Hand& h, Time now) { work(h, now); });
  };
  line_faults.connect([line](const LineFaults& faults) { line->set_faults(faults); });
  mute.connect([&](bool on) { with([on](gcl::Hand& h, Time) { h.set_mute(on); }); });
  no_prompt.connect([&](bool on) { with([on](gcl::Hand& h, Time) { h.set_prompts(!on); }); });
  stuck.connect([&](bool on) { plant.set_stuck(on); });
  reboot.connect([&](bool on) {
    if (on) with([](gcl::Hand& h, Time now) { h.reboot(now); });
  });
  no_gauges.connect([&](bool on) { with([on](gcl::Hand& h, Time) { h.set_gauges(!on); }); });
  prompt_delay.connect([&](double s) { with([s](gcl::Hand& h, Time) { h.set_delay(s); }); });
  refusal.connect([&](int code) { with([code](gcl::Hand& h, Time) { h.set_refusal(code); }); });
  lost_echoes.connect([&](int n) { with([n](gcl::Hand& h, Time) { h.lose_echo(n); }); });
  garbled_blocks.connect([&](int n) { with([n](gcl::Hand& h, Time) { h.garble_blocks(n); }); });
  short_blocks.connect([&](int n) { with([n](gcl::Hand& h, Time) { h.shorten_blocks(n); }); });
  temperature.connect(
      [&](double celsius) { with([celsius](gcl::Hand& h, Time) { h.set_temperature(celsius); }); });
  node.log_info("BH8-262 on {}", settings.line);
  node.spin();
  linger();
}

const graph::RegisteredNodeProgram registered_serial_emulator(
    {"barrett_serial_emulator",
     "Stands in for a BarrettHand BH8-262 at the other end of its serial line: banner, echo, "
     "prompt "
     "and RealTime mode as Barrett's manuals and software show them. Moves the simulated hand by "
     "/world/hand/command and follows its joints on /world/joint_states. Its rate is compared with "
     "that of the line. Faults of the line and of the device are parameters that may be set while "
     "it runs."},
    run_serial_emulator);

}  // namespace
