#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/kuka_rsi/emulator/graph_arm.h"
#include "drivers/kuka_rsi/emulator/served_controller.h"
#include "drivers/wire/node/fault_parameters.h"
#include "drivers/wire/node/linger.h"
#include "nodes/platform_source/platform_source.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::kuka_rsi;

struct EmulatorSettings {
  std::string platform;
  ControllerOptions controller;
  ServedOptions served;
};

void declare_network(graph::Node& node, ServedOptions& s) {
  s.host = node.declare_parameter<std::string>({.name = "pc",
                                                .default_value = s.host,
                                                .description = "IPv4 address of the driver",
                                                .read_only = true});
  s.port = node.declare_parameter<int>({.name = "port",
                                        .default_value = s.port,
                                        .minimum = 1,
                                        .maximum = 65535,
                                        .description = "UDP port of the driver",
                                        .read_only = true});
  s.restart_pause = node.declare_parameter<double>(
      {.name = "restart_pause",
       .default_value = s.restart_pause,
       .unit = "s",
       .minimum = 0,
       .maximum = 60,
       .description = "after RSI has ended, then its program runs again; 0: it does not",
       .read_only = true});
  s.priority = node.declare_parameter<int>(
      {.name = "priority",
       .default_value = s.priority,
       .minimum = 0,
       .maximum = 99,
       .description = "of real-time scheduling of its clock; 0: not asked for",
       .read_only = true});
}

void declare_controller(graph::Node& node, ControllerOptions& c) {
  const int rsi = node.declare_parameter<int>({.name = "rsi",
                                               .default_value = 2,
                                               .minimum = 2,
                                               .maximum = 3,
                                               .description = "version: 2 (KR C2) sends a short "
                                                              "first telegram and four decimals",
                                               .read_only = true});
  c.short_first = rsi == 2;
  const int cycle = node.declare_parameter<int>({.name = "cycle",
                                                 .default_value = 12,
                                                 .unit = "ms",
                                                 .minimum = 4,
                                                 .maximum = 12,
                                                 .description = "12, or 4 with rsi 3",
                                                 .read_only = true});
  if (cycle != 12 && !(cycle == 4 && rsi == 3)) {
    throw std::invalid_argument("parameter 'cycle' is 12, or with rsi 3 also 4 ms");
  }
  c.cycle = 1e-3 * cycle;
  c.ipoc_step = static_cast<std::uint64_t>(cycle);
  const double answer_time = node.declare_parameter<double>(
      {.name = "answer_time",
       .default_value = 0.0,
       .unit = "s",
       .minimum = 0,
       .maximum = 0.012,
       .description = "in which an answer counts; 0: 10 ms with rsi 2, a cycle with 3",
       .read_only = true});
  c.answer_time = answer_time > 0 ? answer_time : rsi == 2 ? 0.010 : c.cycle;
  c.late_limit = node.declare_parameter<int>(
      {.name = "late_limit",
       .default_value = c.late_limit,
       .minimum = 1,
       .maximum = 1000000,
       .description = "telegrams without a good answer that end RSI (eERXmaxLatePackages, Timeout)",
       .read_only = true});
  c.counts_total = node.declare_parameter<bool>(
      {.name = "counts_total",
       .default_value = c.counts_total,
       .description = "... in all, not in a row; KUKA's papers do not settle it",
       .read_only = true});
  c.holds = node.declare_parameter<bool>(
      {.name = "hold_on",
       .default_value = c.holds,
       .description = "HOLDON of the correction: it goes on acting when an answer is missing",
       .read_only = true});
  c.largest_correction = node.declare_parameter<double>(
      {.name = "largest_correction",
       .default_value = c.largest_correction,
       .unit = "deg",
       .minimum = 0.1,
       .maximum = 360,
       .description = "monitor of the whole correction (AXISCORRMON): beyond it RSI ends",
       .read_only = true});
  c.sends_program = node.declare_parameter<bool>({.name = "sends_program",
                                                  .default_value = c.sends_program,
                                                  .description = "its configuration has DEF_ASPos",
                                                  .read_only = true});
  c.names.correction = node.declare_parameter<std::string>(
      {.name = "correction",
       .default_value = c.names.correction,
       .description = "name of the correction in its configuration",
       .read_only = true});
  c.names.type = node.declare_parameter<std::string>(
      {.name = "type", .default_value = c.names.type, .description = "SENTYPE", .read_only = true});
}

void run(graph::Node& node) {
  EmulatorSettings s;
  s.platform = node.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "kr5_pg70",
       .description = "whose arm it moves: joints and their limits",
       .read_only = true});
  const std::string platforms = nodes::declare_platforms(node);
  declare_network(node, s.served);
  declare_controller(node, s.controller);
  LineFaultParameters line_faults(node);
  Switch emergency_stop(node, "emergency_stop", "set to true: RSI ends; its program runs again");
  const robot::KinematicChain chain =
      robot::read_platform(robot::platform_file(platforms, s.platform)).arm_chain();
  if (chain.size() != static_cast<int>(kAxes)) {
    throw std::invalid_argument("platform " + s.platform + " has no arm with six axes");
  }
  std::vector<std::string> joints;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const robot::ChainJoint& joint = chain.joints()[i];
    joints.push_back(joint.name);
    s.controller.lower[i] = joint.lower;
    s.controller.upper[i] = joint.upper;
    s.controller.speed[i] = joint.max_velocity;
  }
  GraphArm arm(node, joints);
  // Its program cannot stand anywhere before the simulated arm does.
  s.served.is_ready = [&arm] { return arm.is_known(); };
  ServedController controller(arm, s.controller, s.served,
                              [&node](const std::string& words) { node.log_info("{}", words); });
  line_faults.connect([&](const LineFaults& faults) { controller.set_faults(faults); });
  emergency_stop.connect([&](bool on) {
    if (on) controller.with_controller([](Controller& c) { c.end("emergency stop"); });
  });
  node.log_info("arm of {}; telegrams every {} ms to {}:{}", s.platform, 1e3 * s.controller.cycle,
                s.served.host, s.served.port);
  node.spin();
  drivers::linger();  // not the socket option of that name
}

const graph::RegisteredNodeProgram registered(
    {"kuka_rsi_emulator",
     "Stands in for a KUKA controller with RSI 2.x or 3.x at the other end of its network: sends "
     "telegrams on its own grid, takes corrections as the controller does or ends RSI where it "
     "would, moves the simulated arm by /world/arm/command and follows its /world/joint_states. "
     "Faults of the network and of the controller are parameters that may be set while it runs."},
    run);

}  // namespace
