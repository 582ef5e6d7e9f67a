#include <memory>
#include <optional>
#include <string>

#include "drivers/pg70/codec/can_framing.h"
#include "drivers/pg70/emulator/graph_gripper.h"
#include "drivers/pg70/emulator/served_module.h"
#include "drivers/wire/can/slcan.h"
#include "drivers/wire/faults/faulty_can.h"
#include "drivers/wire/faults/faulty_stream.h"
#include "drivers/wire/node/fault_parameters.h"
#include "drivers/wire/node/linger.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::pg70;

struct Wire {
  std::unique_ptr<Link> link;
  std::function<void(const LineFaults&)> set_faults;
};

Wire make_wire(const std::string& line, std::uint8_t module) {
  constexpr std::string_view kSerial = "serial:", kSlcan = "slcan:";
  if (line.starts_with(kSerial)) {
    auto stream = std::make_unique<FaultyStream>(
        std::make_unique<PseudoTerminal>(line.substr(kSerial.size())));
    FaultyStream* faulty = stream.get();
    return {make_serial_link(std::move(stream), module, Side::kModule),
            [faulty](const LineFaults& faults) { faulty->set_faults(faults); }};
  }
  std::unique_ptr<CanBus> bus;
  if (line.starts_with(kSlcan)) {
    bus = std::make_unique<Slcan>(std::make_unique<PseudoTerminal>(line.substr(kSlcan.size())), 0,
                                  std::vector<std::uint16_t>{});
  } else {
    bus = open_can_bus(line, 0, {can_identifier(Direction::kCommand, module)});
  }
  auto faulty_bus = std::make_unique<FaultyCan>(std::move(bus));
  FaultyCan* faulty = faulty_bus.get();
  return {make_can_link(std::move(faulty_bus), module, Side::kModule),
          [faulty](const LineFaults& faults) { faulty->set_faults(faults); }};
}

void run(graph::Node& node) {
  const auto line = node.declare_parameter<std::string>(
      {.name = "can",
       .default_value = "vcan0",
       .description =
           "a CAN interface, or slcan:FILE, serial:FILE: the emulated line is made there",
       .read_only = true});
  const auto module_id =
      static_cast<std::uint8_t>(node.declare_parameter<int>({.name = "module_id",
                                                             .default_value = 12,
                                                             .minimum = 1,
                                                             .maximum = 255,
                                                             .description = "that it answers to",
                                                             .read_only = true}));
  const auto gripper_file = node.declare_parameter<std::string>(
      {.name = "gripper",
       .default_value = text::tree_file("config/robots/pg70_dsa.yaml"),
       .description = "gripper model: the module's limits",
       .read_only = true});
  ModuleOptions options;
  options.referenced = node.declare_parameter<bool>({.name = "referenced",
                                                     .default_value = true,
                                                     .description = "at power-on",
                                                     .read_only = true});
  options.blocked_time = node.declare_parameter<double>(
      {.name = "blocked_time",
       .default_value = options.blocked_time,
       .unit = "s",
       .minimum = 0.01,
       .maximum = 10,
       .description =
           "of standing that end a motion as blocked; longer where the simulation may lag",
       .read_only = true});
  LineFaultParameters line_faults(node);
  Switch mute(node, "mute", "nothing that it says arrives");
  Switch stuck(node, "stuck", "the fingers cannot move");
  Switch reboot(node, "reboot", "set to true: starts anew");
  LateParameter<int> deaf_to(node,
                             {.name = "deaf_to",
                              .default_value = 0,
                              .minimum = 0,
                              .maximum = 255,
                              .description = "command code that gets lost on its way to it, e.g. "
                                             "145: CMD STOP; 0: none"});
  LateParameter<int> fault(node, {.name = "fault",
                                  .default_value = 0,
                                  .minimum = 0,
                                  .maximum = 255,
                                  .description = "raises this error code; 0: the cause is gone"});
  const robot::GripperModel model = robot::read_gripper_model(gripper_file);
  options.max_opening = model.max_opening;
  options.max_speed = model.max_speed;
  options.max_acceleration = model.max_acceleration;
  options.nominal_current = model.nominal_current;
  options.max_current = model.max_current;
  GraphGripper gripper(node);
  Wire wire = make_wire(line, module_id);
  const auto set_faults = wire.set_faults;
  ServedModule module(gripper, options, std::move(wire.link));
  line_faults.connect(set_faults);
  mute.connect([&](bool on) { module.with_module([on](Module& m, Time) { m.set_mute(on); }); });
  stuck.connect([&](bool on) { gripper.set_stuck(on); });
  reboot.connect([&](bool on) {
    if (on) module.with_module([](Module& m, Time now) { m.reboot(now); });
  });
  deaf_to.connect([&](int code) {
    module.with_module([code](Module& m, Time) {
      m.set_deaf_to(code == 0 ? std::nullopt : std::optional(static_cast<Command>(code)));
    });
  });
  fault.connect([&](int code) {
    module.with_module([code](Module& m, Time now) {
      if (code == 0) return m.mend(now);
      m.fail(static_cast<ErrorCode>(code), true, now);
    });
  });
  node.log_info("module {} on {}", module_id, line);
  node.spin();
  linger();
}

const graph::RegisteredNodeProgram registered(
    {"pg70_emulator",
     "Stands in for a Schunk PG70 at the other end of its wire: answers the Schunk Motion Protocol "
     "as the manual describes it, moves the simulated gripper by /world/gripper/command and "
     "follows its /world/gripper/state. Faults of the wire and of the device are parameters that "
     "may be set while it runs."},
    run);

}  // namespace
